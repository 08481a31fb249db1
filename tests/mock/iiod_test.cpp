#include "tests/mock/iiod.hpp"

#include <gtest/gtest.h>
#include <iio.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivers/errors.hpp"
#include "tests/support/devices/iiod_pattern.hpp"

namespace shaker::mock {
namespace {

using test::numbered;
using test::pattern;

bool soon(const std::function<bool()>& true_now) {
    for (int i = 0; i < 2000 && !true_now(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds{2});
    return true_now();
}

/// libiio's own client.
struct Client {
    std::unique_ptr<iio_context, void (*)(iio_context*)> context{nullptr, iio_context_destroy};
    std::unique_ptr<iio_buffer, void (*)(iio_buffer*)> buffer{nullptr, iio_buffer_destroy};
    iio_device* device = nullptr;

    explicit Client(const Iiod& iiod, unsigned timeout_ms = 3000) {
        std::signal(SIGPIPE, SIG_IGN);  // libiio writes to closed sockets
        context.reset(iio_create_context_from_uri(("ip:127.0.0.1:" + std::to_string(iiod.port())).c_str()));
        if (!context) return;
        iio_context_set_timeout(context.get(), timeout_ms);
        device = iio_context_find_device(context.get(), "iio:device0");
    }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;
    ~Client() { buffer.reset(); }

    [[nodiscard]] iio_channel* channel(const char* id) const {
        return iio_device_find_channel(device, id, false);
    }
    void open(const std::vector<const char*>& channels, std::size_t samples) {
        for (const char* id : channels) iio_channel_enable(channel(id));
        buffer.reset(iio_device_create_buffer(device, samples, false));
    }
    [[nodiscard]] ssize_t refill() const { return iio_buffer_refill(buffer.get()); }
    template <class T>
    [[nodiscard]] std::vector<T> values(const char* id) const {
        std::vector<T> all;
        const iio_channel* c = channel(id);
        for (auto* p = static_cast<char*>(iio_buffer_first(buffer.get(), c));
             p < iio_buffer_end(buffer.get()); p += iio_buffer_step(buffer.get())) {
            T value{};
            iio_channel_convert(c, &value, p);
            all.push_back(value);
        }
        return all;
    }
};

std::string read(const Client& c, const iio_channel* channel, const char* name) {
    char text[256] = {};
    const auto rc = channel != nullptr ? iio_channel_attr_read(channel, name, text, sizeof text)
                                       : iio_device_attr_read(c.device, name, text, sizeof text);
    return rc < 0 ? std::to_string(rc) : std::string{text};
}

void push(Iiod& iiod, std::int64_t from, std::int64_t to) {
    std::vector<IiodSample> samples;
    for (std::int64_t n = from; n < to; ++n) samples.push_back({pattern(n), 1'000'000'000 + 250'000 * n});
    iiod.push(samples);
}

TEST(IiodTest, ShowsItsAccelerometerToARealClient) {
    Iiod iiod{{.label = "base", .serial = "1234", .offset_counts = {0, 5, -7}}};
    const Client c{iiod};
    ASSERT_NE(c.context, nullptr);
    EXPECT_STREQ(iio_device_get_name(c.device), "adxl355");
    EXPECT_STREQ(iio_device_get_label(c.device), "base");
    EXPECT_EQ(iio_context_find_device(c.context.get(), "base"), c.device);
    EXPECT_EQ(iio_device_get_channels_count(c.device), 4U);
    EXPECT_EQ(read(c, c.channel("accel_z"), "scale"), "3.8245e-05");
    EXPECT_EQ(read(c, c.channel("accel_z"), "offset"), "-7");
    EXPECT_EQ(read(c, nullptr, "serial_number"), "1234");
    EXPECT_EQ(read(c, nullptr, "no_such_thing"), "-2");
    const iio_data_format* f = iio_channel_get_data_format(c.channel("accel_x"));
    EXPECT_TRUE(f->is_be && f->is_signed && f->bits == 20 && f->length == 32 && f->shift == 12);
    unsigned major = 0, minor = 0;
    char tag[8] = {};
    EXPECT_EQ(iio_context_get_version(c.context.get(), &major, &minor, tag), 0);
    EXPECT_EQ(minor, 24U);
}

TEST(IiodTest, ClientChoosesAvailableRateAndClock) {
    Iiod iiod{{}};
    const Client c{iiod};
    iio_channel* x = c.channel("accel_x");
    EXPECT_GT(iio_channel_attr_write(x, "sampling_frequency", "1000"), 0);
    EXPECT_EQ(iiod.rate_hz(), 1000);
    EXPECT_EQ(iio_channel_attr_write(x, "sampling_frequency", "1234"), -EINVAL);
    EXPECT_EQ(iio_channel_attr_write(x, "scale", "1"), -EACCES);
    EXPECT_EQ(iiod.rate_hz(), 1000);
    EXPECT_EQ(read(c, nullptr, "current_timestamp_clock"), "realtime");
    EXPECT_GT(iio_device_attr_write(c.device, "current_timestamp_clock", "monotonic"), 0);
    EXPECT_EQ(read(c, nullptr, "current_timestamp_clock"), "monotonic");
}

TEST(IiodTest, AssignsAndRemovesTrigger) {
    Iiod iiod{{}};
    const Client c{iiod};
    const iio_device* trigger = nullptr;
    ASSERT_EQ(iio_device_get_trigger(c.device, &trigger), 0);
    EXPECT_STREQ(iio_device_get_name(trigger), "adxl355-dev0");
    EXPECT_EQ(iio_device_set_trigger(c.device, nullptr), 0);
    EXPECT_EQ(iio_device_get_trigger(c.device, &trigger), 0);
    EXPECT_EQ(trigger, nullptr);
}

TEST(IiodTest, EverySampleArrivesOnceWithItsStamp) {
    Iiod iiod{{}};
    Client c{iiod};
    c.open({"accel_x", "accel_y", "accel_z", "timestamp"}, 50);
    ASSERT_NE(c.buffer, nullptr);
    push(iiod, 262100, 262300);
    for (std::int64_t n = 262100; n < 262300;) {
        ASSERT_EQ(c.refill(), 50 * 24);
        const auto x = c.values<std::int32_t>("accel_x"), y = c.values<std::int32_t>("accel_y"),
                   z = c.values<std::int32_t>("accel_z");
        const auto stamps = c.values<std::int64_t>("timestamp");
        for (std::size_t i = 0; i < 50; ++i, ++n) {
            ASSERT_EQ(numbered({x[i], y[i], z[i]}), n);
            ASSERT_EQ(stamps[i], 1'000'000'000 + 250'000 * n);
        }
    }
    EXPECT_TRUE(soon([&] { return iiod.counts().served == 200; }));
    EXPECT_EQ(iiod.counts().pushed, 200U);
    EXPECT_EQ(iiod.counts().connections, 2U);  // one for commands, one for the buffer
}

TEST(IiodTest, EachOfSeveralClientsGetsTheChannelsItChose) {
    Iiod iiod{{}};
    Client a{iiod}, b{iiod};
    a.open({"accel_z"}, 20);
    b.open({"accel_x", "timestamp"}, 40);
    push(iiod, 0, 40);
    ASSERT_EQ(a.refill(), 20 * 4);
    EXPECT_EQ(a.values<std::int32_t>("accel_z")[19], -19);
    ASSERT_EQ(b.refill(), 40 * 16);
    EXPECT_EQ(b.values<std::int32_t>("accel_x")[39], 39);
    EXPECT_EQ(b.values<std::int64_t>("timestamp")[39], 1'000'000'000 + 250'000 * 39);
}

TEST(IiodTest, DeliversSixteenBits) {
    Iiod iiod{{.bits = 12}};
    Client c{iiod};
    c.open({"accel_x", "accel_y", "accel_z", "timestamp"}, 2);
    const std::vector<IiodSample> samples{{{2047, -2048, -1}, 5}, {{0, 1, 2}, -6}};
    iiod.push(samples);
    ASSERT_EQ(c.refill(), 2 * 16);
    EXPECT_EQ(c.values<std::int16_t>("accel_x")[0], 2047);
    EXPECT_EQ(c.values<std::int16_t>("accel_y")[0], -2048);
    EXPECT_EQ(c.values<std::int16_t>("accel_z")[0], -1);
    EXPECT_EQ(c.values<std::int64_t>("timestamp")[1], -6);
}

TEST(IiodTest, AFullFifoLosesTheNewestAndCountsThem) {
    Iiod iiod{{.fifo = 100}};
    Client c{iiod};
    c.open({"accel_x"}, 50);
    push(iiod, 0, 130);
    EXPECT_TRUE(soon([&] { return iiod.counts().overflowed == 30; }));
    ASSERT_EQ(c.refill(), 200);
    ASSERT_EQ(c.refill(), 200);
    EXPECT_EQ(c.values<std::int32_t>("accel_x")[49], 99);
    push(iiod, 130, 180);
    ASSERT_EQ(c.refill(), 200);
    c.buffer.reset();
    EXPECT_EQ(iiod.counts().unread, 0U);
    EXPECT_EQ(iiod.counts().overflowed, 30U);
}

TEST(IiodTest, FifoHoldsRequestedBuffers) {
    Iiod iiod{{}};
    Client c{iiod};
    ASSERT_EQ(iio_device_set_kernel_buffers_count(c.device, 16), 0);
    c.open({"accel_x"}, 50);
    push(iiod, 0, 830);
    EXPECT_TRUE(soon([&] { return iiod.counts().overflowed == 30; })) << iiod.counts().overflowed;
    for (int k = 0; k < 16; ++k) ASSERT_EQ(c.refill(), 200);
    EXPECT_EQ(c.values<std::int32_t>("accel_x")[49], 799);
}

TEST(IiodTest, EveryPushedSampleIsAccountedFor) {
    Iiod iiod{{.fifo = 64}};
    push(iiod, 0, 10);  // nobody listens
    {
        Client c{iiod};
        c.open({"accel_x"}, 32);
        iiod.drop(5);
        push(iiod, 10, 100);
        ASSERT_EQ(c.refill(), 128);
    }
    EXPECT_TRUE(soon([&] {
        const IiodCounts n = iiod.counts();
        return n.pushed == n.dropped + n.unheard + n.served + n.overflowed + n.unread;
    }));
    const IiodCounts n = iiod.counts();
    EXPECT_EQ(n.pushed, 100U);
    EXPECT_EQ(n.unheard, 10U);
    EXPECT_EQ(n.dropped, 5U);
    EXPECT_EQ(n.served, 32U);
    EXPECT_EQ(n.overflowed, 0U) << "the client was sent nothing after what was lost";
    EXPECT_EQ(n.unread, 85U - 32U);  // 21 of them for want of room
}

TEST(IiodTest, SilenceEndsAsABrokenPipeAtTheClient) {
    Iiod iiod{{}};
    Client c{iiod, 300};
    c.open({"accel_x"}, 10);
    iiod.silence(1);
    push(iiod, 0, 10);
    EXPECT_EQ(c.refill(), -EPIPE);
}

TEST(IiodTest, AShortSilenceIsOnlyADelay) {
    Iiod iiod{{}};
    Client c{iiod};
    c.open({"accel_x"}, 10);
    iiod.silence(0.1);
    push(iiod, 0, 10);
    EXPECT_EQ(c.refill(), 40);
}

TEST(IiodTest, SilentSensorTimesOutAtTheServer) {
    Iiod iiod{{}};
    Client c{iiod, 2000};  // the server waits half as long
    c.open({"accel_x"}, 10);
    EXPECT_EQ(c.refill(), -ETIMEDOUT);
}

TEST(IiodTest, AnErrorEndsTheBuffer) {
    Iiod iiod{{}};
    Client c{iiod};
    c.open({"accel_x"}, 10);
    iiod.error(-EIO);
    EXPECT_EQ(c.refill(), -EIO);
    EXPECT_EQ(c.refill(), -EBADF);
}

TEST(IiodTest, DisconnectedClientMayReconnect) {
    Iiod iiod{{}};
    Client c{iiod};
    c.open({"accel_x"}, 10);
    iiod.disconnect();
    EXPECT_LT(c.refill(), 0);
    Client again{iiod};
    again.open({"accel_x"}, 10);
    ASSERT_NE(again.buffer, nullptr);
    push(iiod, 0, 10);
    EXPECT_EQ(again.refill(), 40);
}

TEST(IiodTest, ACancelledClientGetsABadFileNumber) {
    Iiod iiod{{}};
    Client c{iiod};
    c.open({"accel_x"}, 10);
    std::jthread other{[&] {
        std::this_thread::sleep_for(std::chrono::milliseconds{50});
        iio_buffer_cancel(c.buffer.get());
    }};
    EXPECT_EQ(c.refill(), -EBADF);
}

TEST(IiodTest, FrozenSensorRepeatsCountsNotStamps) {
    Iiod iiod{{}};
    Client c{iiod};
    c.open({"accel_x", "timestamp"}, 100);
    push(iiod, 0, 10);
    iiod.freeze(0.01);  // 40 samples
    push(iiod, 10, 100);
    ASSERT_EQ(c.refill(), 1600);
    const auto x = c.values<std::int32_t>("accel_x");
    EXPECT_EQ(x[9], 9);
    EXPECT_EQ(x[49], 9);
    EXPECT_EQ(x[50], 50);
    EXPECT_EQ(c.values<std::int64_t>("timestamp")[49], 1'000'000'000 + 250'000 * 49);
}

TEST(IiodTest, StampsJumpAndAreLateOnCommand) {
    Iiod iiod{{}};
    Client c{iiod};
    c.open({"timestamp"}, 2000);
    iiod.shift_stamps(-7000);
    push(iiod, 0, 1000);
    iiod.shift_stamps(7000);
    iiod.jitter_stamps(4'600'000);
    push(iiod, 1000, 2000);
    ASSERT_EQ(c.refill(), 16000);
    const auto stamps = c.values<std::int64_t>("timestamp");
    EXPECT_EQ(stamps[999], 1'000'000'000 + 250'000 * 999 - 7000);
    std::int64_t latest = 0;
    for (int n = 1000; n < 2000; ++n) {
        const std::int64_t late = stamps[static_cast<std::size_t>(n)] - (1'000'000'000 + 250'000LL * n);
        ASSERT_GE(late, 0);
        ASSERT_GT(stamps[static_cast<std::size_t>(n)], stamps[static_cast<std::size_t>(n - 1)]);
        latest = std::max(latest, late);
    }
    EXPECT_GT(latest, 250'000);
    EXPECT_LT(latest, 4'800'000);
}

TEST(IiodTest, NamesPortInUse) {
    const Iiod iiod{{}};
    try {
        const Iiod other{{}, iiod.port()};
        FAIL();
    } catch (const DeviceError& e) {
        EXPECT_NE(std::string{e.what()}.find(std::to_string(iiod.port())), std::string::npos);
    }
    EXPECT_THROW((Iiod{{.bits = 33}}), InputError);
}

TEST(IiodProtocolTest, RefusesUnknownCommands) {
    EXPECT_EQ(parse_iiod_command("\r\n").verb, IiodVerb::none);
    EXPECT_EQ(parse_iiod_command("ZPRINT\r\n").verb, IiodVerb::refused);
    EXPECT_EQ(parse_iiod_command("OPEN iio:device0 many 0000000f").verb, IiodVerb::refused);
    EXPECT_EQ(parse_iiod_command("TIMEOUT").verb, IiodVerb::refused);
    EXPECT_EQ(parse_iiod_command("print").verb, IiodVerb::print);
    const IiodCommand write = parse_iiod_command("WRITE iio:device0 INPUT accel_x sampling_frequency 5\r\n");
    EXPECT_EQ(write.verb, IiodVerb::write);
    EXPECT_EQ(write.channel, "accel_x");
    EXPECT_EQ(write.attribute, "sampling_frequency");
    EXPECT_EQ(write.number, 5U);
    std::uint32_t mask = 0;
    EXPECT_TRUE(decode_iiod_mask("00000009", mask));
    EXPECT_EQ(mask, 9U);
    EXPECT_FALSE(decode_iiod_mask("0000000g", mask));
    EXPECT_FALSE(decode_iiod_mask("9", mask));
    EXPECT_EQ(encode_iiod_mask(0xf), "0000000f");
}

}  // namespace
}  // namespace shaker::mock
