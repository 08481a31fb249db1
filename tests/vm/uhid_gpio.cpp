// A GPIO chip for the kernel: the MCP2221 of the driver hid-mcp2221, in user space. uhid_gpio LOG makes line
// 1, an input, high at SIGUSR1 and writes "open NANOSECONDS" (CLOCK_MONOTONIC) to LOG.
#include <fcntl.h>
#include <linux/input.h>
#include <linux/uhid.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <string_view>
#include <system_error>

namespace {

constexpr std::uint32_t maker = 0x04D8, product = 0x00DD;
constexpr int input_line = 1;

// Commands of the chip, the first byte of 64 (data sheet of the MCP2221A, section 3.1).
constexpr std::uint8_t set_lines = 0x50, get_lines = 0x51;
constexpr std::size_t report_bytes = 64, lines_held = 4;

// One vendor-defined collection with an input and an output report of 64 bytes.
constexpr std::uint8_t descriptor[] = {0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1,         0x01, 0x09, 0x02,
                                       0x15, 0x00, 0x26, 0xFF, 0x00, 0x75,         8,    0x95, report_bytes,
                                       0x81, 0x02, 0x09, 0x03, 0x95, report_bytes, 0x91, 0x02, 0xC0};

int check(int rc, const char* what) {
    if (rc < 0) throw std::system_error{errno, std::generic_category(), what};
    return rc;
}

void send(int hid, const uhid_event& event) {
    check(static_cast<int>(write(hid, &event, sizeof event)), "write to /dev/uhid");
}

long long now_ns() {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1'000'000'000LL * t.tv_sec + t.tv_nsec;
}

class Chip {
public:
    Chip(int hid, std::FILE* log) : hid_{hid}, log_{log} {
        uhid_event event{};
        event.type = UHID_CREATE2;
        constexpr std::string_view name = "shaker test lines";
        name.copy(reinterpret_cast<char*>(event.u.create2.name), name.size());
        event.u.create2.bus = BUS_USB;
        event.u.create2.vendor = maker;
        event.u.create2.product = product;
        event.u.create2.rd_size = sizeof descriptor;
        std::memcpy(event.u.create2.rd_data, descriptor, sizeof descriptor);
        send(hid_, event);
    }
    void answer() {
        uhid_event event{};
        check(static_cast<int>(read(hid_, &event, sizeof event)), "read from /dev/uhid");
        if (event.type != UHID_OUTPUT) return;  // a request may be shorter than a report: zeros follow
        uhid_event reply{};
        reply.type = UHID_INPUT2;
        reply.u.input2.size = report_bytes;
        std::memcpy(reply.u.input2.data, event.u.output.data, report_bytes);
        reply.u.input2.data[1] = 0;  // success
        if (event.u.output.data[0] == set_lines) set(event.u.output.data + 2);
        if (event.u.output.data[0] == get_lines) get(reply.u.input2.data + 2);
        send(hid_, reply);
    }
    void open_contact() {
        lines_[input_line].high = 1;
        std::fprintf(log_, "open %lld\n", now_ns());
    }

private:
    struct Line {
        std::uint8_t input = 1, high = 0;
    };
    // Four bytes a line: change the level, level, change the direction, direction.
    void set(const std::uint8_t* request) {
        for (std::size_t i = 0; i < lines_held; ++i) {
            const std::uint8_t* r = request + 4 * i;
            if (r[2] != 0) lines_[i].input = r[3];
            if (r[0] != 0) lines_[i].high = r[1];
        }
    }
    // Two bytes a line: direction, level, as the kernel's driver reads them.
    void get(std::uint8_t* reply) const {
        for (std::size_t i = 0; i < lines_held; ++i) {
            reply[2 * i] = lines_[i].input;
            reply[2 * i + 1] = lines_[i].high;
        }
    }

    int hid_;
    std::FILE* log_;
    std::array<Line, lines_held> lines_{};
};

void serve(std::FILE* log) {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGUSR1);
    check(sigprocmask(SIG_BLOCK, &signals, nullptr), "signals");
    const int told = check(signalfd(-1, &signals, SFD_CLOEXEC), "signals");
    const int hid = check(open("/dev/uhid", O_RDWR | O_CLOEXEC), "/dev/uhid");
    Chip chip{hid, log};
    std::array<pollfd, 2> ready{{{hid, POLLIN, 0}, {told, POLLIN, 0}}};
    for (;;) {
        check(poll(ready.data(), ready.size(), -1), "poll");
        if (ready[0].revents != 0) chip.answer();
        if (ready[1].revents == 0) continue;
        signalfd_siginfo signal{};
        check(static_cast<int>(read(told, &signal, sizeof signal)), "signals");
        chip.open_contact();
    }
}

}  // namespace

int main(int argc, char** argv) try {
    std::FILE* const log = argc == 2 ? std::fopen(argv[1], "w") : nullptr;
    if (log == nullptr) {
        std::fputs("usage: uhid_gpio LOG\n", stderr);
        return 2;
    }
    std::setvbuf(log, nullptr, _IOLBF, BUFSIZ);
    serve(log);
} catch (const std::exception& error) {
    std::fprintf(stderr, "uhid_gpio: %s\n", error.what());
    return 1;
}
