// A three-axis accelerometer for the kernel: a HID sensor hub in user space. uhid_accelerometer RATE_HZ sends
// samples until it is killed: axis z counts them, x and y are multiples of the count.
#include <fcntl.h>
#include <linux/input.h>
#include <linux/uhid.h>
#include <poll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <system_error>

namespace {

constexpr std::uint8_t report_id = 1;

// Short items of a report descriptor: the lowest two bits of the first byte are the number of following
// bytes.
constexpr std::uint8_t descriptor[] = {
    0x05, 0x20,  // usage page: sensor
    0x09, 0x73,  // usage: accelerometer 3D
    0xA1, 0x00,  // collection: physical
    0x85, report_id,
    // feature: report interval, ms
    0x0A, 0x0E, 0x03, 0x15, 0x00, 0x27, 0xFF, 0xFF, 0xFF, 0x7F, 0x75, 32, 0x95, 1, 0xB1, 0x02,
    // feature: reporting state, one of six
    0x0A, 0x16, 0x03, 0x15, 0x00, 0x25, 0x05, 0x75, 8, 0x95, 1, 0xA1, 0x02,  //
    0x0A, 0x40, 0x08, 0x0A, 0x41, 0x08, 0x0A, 0x42, 0x08, 0x0A, 0x43, 0x08, 0x0A, 0x44, 0x08, 0x0A, 0x45,
    0x08, 0xB1, 0x00, 0xC0,
    // feature: power state, one of six
    0x0A, 0x19, 0x03, 0x15, 0x00, 0x25, 0x05, 0x75, 8, 0x95, 1, 0xA1, 0x02,  //
    0x0A, 0x50, 0x08, 0x0A, 0x51, 0x08, 0x0A, 0x52, 0x08, 0x0A, 0x53, 0x08, 0x0A, 0x54, 0x08, 0x0A, 0x55,
    0x08, 0xB1, 0x00, 0xC0,
    // input: acceleration along x, y, z: 32 bits, signed, 1e-5 of standard gravity
    0x17, 0x00, 0x00, 0x00, 0x80, 0x27, 0xFF, 0xFF, 0xFF, 0x7F, 0x55, 0x0B, 0x75, 32, 0x95, 1,  //
    0x0A, 0x53, 0x04, 0x81, 0x02, 0x0A, 0x54, 0x04, 0x81, 0x02, 0x0A, 0x55, 0x04, 0x81, 0x02, 0xC0};

int check(int rc, const char* what) {
    if (rc < 0) throw std::system_error{errno, std::generic_category(), what};
    return rc;
}

void send(int hid, const uhid_event& event) {
    check(static_cast<int>(write(hid, &event, sizeof event)), "write to /dev/uhid");
}

void create(int hid) {
    uhid_event event{};
    event.type = UHID_CREATE2;
    constexpr std::string_view name = "shaker test accelerometer";
    name.copy(reinterpret_cast<char*>(event.u.create2.name), name.size());
    event.u.create2.bus = BUS_USB;  // the sensor hub's driver supports USB and I2C only
    event.u.create2.rd_size = sizeof descriptor;
    std::memcpy(event.u.create2.rd_data, descriptor, sizeof descriptor);
    send(hid, event);
}

using Sample = std::array<std::uint8_t, 1 + 3 * sizeof(std::int32_t)>;

Sample sample(std::int32_t count) {
    const std::array<std::int32_t, 3> axes{3 * count, -5 * count, count};
    Sample report{report_id};
    std::memcpy(report.data() + 1, axes.data(), sizeof axes);
    return report;
}

void send_sample(int hid, std::int32_t count) {
    const Sample report = sample(count);
    uhid_event event{};
    event.type = UHID_INPUT2;
    event.u.input2.size = report.size();
    std::memcpy(event.u.input2.data, report.data(), report.size());
    send(hid, event);
}

// The feature report: interval, reporting state, power state. The kernel reads back the values it has set.
// The interval stays 0 (unknown), because the kernel stores whole milliseconds, which would limit the rate to
// 1 kHz.
using Features = std::array<std::uint8_t, 7>;

template <std::size_t size>
void reply(int hid, const uhid_get_report_req& request, const std::array<std::uint8_t, size>& report) {
    uhid_event event{};
    event.type = UHID_GET_REPORT_REPLY;
    event.u.get_report_reply.id = request.id;
    event.u.get_report_reply.size = size;
    std::memcpy(event.u.get_report_reply.data, report.data(), size);
    send(hid, event);
}

void take(int hid, const uhid_set_report_req& request, Features& features) {
    if (request.size == features.size()) std::memcpy(features.data(), request.data, features.size());
    uhid_event event{};
    event.type = UHID_SET_REPORT_REPLY;
    event.u.set_report_reply.id = request.id;
    send(hid, event);
}

void feed(double rate_hz) {
    const int hid = check(open("/dev/uhid", O_RDWR | O_CLOEXEC), "/dev/uhid");
    const int timer = check(timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC), "timerfd");
    const timespec period{0, static_cast<long>(1e9 / rate_hz)};
    const itimerspec every{period, period};
    check(timerfd_settime(timer, 0, &every, nullptr), "timerfd");
    create(hid);
    Features features{report_id};
    bool wanted = false;
    std::int32_t count = 0;
    std::array<pollfd, 2> ready{{{hid, POLLIN, 0}, {timer, POLLIN, 0}}};
    for (;;) {
        check(poll(ready.data(), ready.size(), -1), "poll");
        if (ready[0].revents != 0) {
            uhid_event event{};
            check(static_cast<int>(read(hid, &event, sizeof event)), "read from /dev/uhid");
            if (event.type == UHID_OPEN) wanted = true;
            if (event.type == UHID_CLOSE) wanted = false;
            if (event.type == UHID_SET_REPORT) take(hid, event.u.set_report, features);
            if (event.type == UHID_GET_REPORT && event.u.get_report.rtype == UHID_FEATURE_REPORT)
                reply(hid, event.u.get_report, features);
            else if (event.type == UHID_GET_REPORT)
                reply(hid, event.u.get_report, sample(count));
        }
        if (ready[1].revents != 0) {
            std::uint64_t due = 0;
            check(static_cast<int>(read(timer, &due, sizeof due)), "timerfd");
            for (; wanted && due > 0; --due) send_sample(hid, count++);
        }
    }
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc != 2) {
        std::fputs("usage: uhid_accelerometer RATE_HZ\n", stderr);
        return 2;
    }
    feed(std::strtod(argv[1], nullptr));
} catch (const std::exception& error) {
    std::fprintf(stderr, "uhid_accelerometer: %s\n", error.what());
    return 1;
}
