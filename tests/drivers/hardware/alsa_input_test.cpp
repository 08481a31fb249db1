// An analog accelerometer on the inputs of a sound card: settings, names of USB sensors, reduction of the
// rate, and a mock card through real libasound.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <thread>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa_input/alsa_accelerometer.hpp"
#include "drivers/hardware/alsa_input/rate_reducer.hpp"
#include "tests/mock/converter.hpp"
#include "tests/mock/sound/line_input.hpp"
#include "tests/support/no_alloc.hpp"
#include "tests/support/paths.hpp"

namespace shaker::alsa_input {
namespace {

using namespace std::chrono_literals;
constexpr double pi = std::numbers::pi;

InputSettings read(const std::string& text) {
    SettingsTable table = SettingsTable::from_text(text, "rigs/bench.toml");
    InputSettings settings = read_input_settings(table);
    table.finish();
    return settings;
}

std::string refusal(const std::string& text) {
    try {
        read(text);
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

TEST(AlsaInputSettingsTest, SensitivityIsPerG) {
    const InputSettings s = read(
        "pcm = 'hw:CARD=M4'\nfull_scale_V = 5\nsensitivity_mv_per_g = 100\n"
        "conditioner_gain = 10");
    EXPECT_EQ(s.channels, std::vector{1});
    EXPECT_EQ(s.reduce, 12);
    EXPECT_EQ(s.sensor_rate_hz(), 4000);
    EXPECT_FALSE(s.gravity);
    EXPECT_EQ(s.shaker_axis, (std::array<double, 3>{1, 0, 0}));
    EXPECT_NEAR(s.full_scale_mps2({}, 0), 5 * 9.80665, 1e-9);
    EXPECT_NEAR(read("pcm = 'x'\nfull_scale_V = 1\nsensitivity_mv_per_mps2 = 10.2").full_scale_mps2({}, 0),
                1 / 10.2e-3, 1e-9);
}

// The filter's delay and a block together are at most 16 ms at any rate of the card.
TEST(AlsaInputSettingsTest, EveryRateKeepsItsTimes) {
    for (const int rate : {8000, 16000, 44100, 48000, 88200, 96000, 192000, 384000, 768000}) {
        const InputSettings s = read("pcm = 'x'\nrate_hz = " + std::to_string(rate));
        EXPECT_GE(s.sensor_rate_hz(), 4000) << rate;
        EXPECT_LT(s.sensor_rate_hz(), 8000) << rate;
        const double s_total = RateReducer{s.reduce}.delay() / static_cast<double>(s.rate_hz) +
                               s.block_samples() / s.sensor_rate_hz();
        EXPECT_LE(s_total, 0.016) << rate;
    }
}

TEST(AlsaInputSettingsTest, WrongValuesAreNamed) {
    EXPECT_NE(refusal("full_scale_V = 1").find("pcm"), std::string::npos);
    EXPECT_NE(refusal("pcm = 'x'\nchannels = [1, 1]").find("channel 1 is given twice"), std::string::npos);
    EXPECT_NE(refusal("pcm = 'x'\nchannels = [1, 2, 3, 4]").find("1 to 3"), std::string::npos);
    EXPECT_NE(refusal("pcm = 'x'\nchannels = [1.5]").find("whole number"), std::string::npos);
    EXPECT_NE(
        refusal("pcm = 'x'\nsensitivity_mv_per_g = 100\nsensitivity_mv_per_mps2 = 10").find("one of them"),
        std::string::npos);
    EXPECT_NE(refusal("pcm = 'x'\nshaker_axis = [0, 1, 0]").find("part along y"), std::string::npos);
    EXPECT_NE(refusal("pcm = 'x'\nreduce = 49").find("1 to 48"), std::string::npos);
    for (const char* text : {"pcm = 'x'", "pcm = 'x'\nsensitivity_mv_per_g = 100"})
        EXPECT_THROW(static_cast<void>(read(text).full_scale_mps2({}, 0)), DeviceError);
}

TEST(UsbSensorTest, NamesStateSensitivity) {
    const auto digiducer = usb_sensor("333D01 1012345123451234622062 at usb-0000:00:14.0-2, full speed");
    EXPECT_FALSE(digiducer) << "a digit short of the date";
    const auto found = usb_sensor("TMS 333D01 10123455432154322220621 at usb-0000:00:14.0-2, full speed");
    ASSERT_TRUE(found);
    EXPECT_EQ(found->model, "333D01");
    EXPECT_EQ(found->serial, "012345");
    EXPECT_EQ(found->date, "220621");
    EXPECT_FALSE(found->volts);
    EXPECT_NEAR(found->full_scale[0], 8388608.0 / 54321, 1e-9);  // m/s^2: 855400 / 54321 g
    EXPECT_NEAR(found->full_scale[0] / 9.80665, 855400.0 / 54321, 1e-3);
    EXPECT_NEAR(found->full_scale[1], 8388608.0 / 54322, 1e-9);
    const auto conditioner = usb_sensor("485B39 200654308388600838861220101");
    ASSERT_TRUE(conditioner);
    EXPECT_TRUE(conditioner->volts);
    EXPECT_EQ(conditioner->serial, "006543");
    EXPECT_NEAR(conditioner->full_scale[0], 8388608.0 / 838860, 1e-9);  // V
    const auto fine = usb_sensor("485B39 300654308388600838861220101");
    ASSERT_TRUE(fine);
    EXPECT_NEAR(fine->full_scale[0], 8388608.0 / 838860 / 20, 1e-9);
    for (const char* other : {"", "MOTU M4", "333D01", "333D01 4012345123451234620220621",
                              "333D01 1012345123x51234620220621", "485B39 20065430838860"})
        EXPECT_FALSE(usb_sensor(other)) << other;
}

// Response of the reducer at a share of the reduced rate, relative to the sample at its delay.
std::complex<double> response(int n, double share) {
    RateReducer r{n};
    const int count = 2 * r.delay() + 1;
    std::array<std::complex<double>, 2> parts;
    const auto wave = [&](int i) { return 2 * pi * share * (i - (count - 1 - r.delay())) / n; };
    for (int i = 0; i < count; ++i) r.add({std::cos(wave(i)), std::sin(wave(i)), 1});
    const auto v = r.value();
    EXPECT_NEAR(v[2], 1, 1e-12) << "a constant stays";
    return {v[0], v[1]};
}

TEST(RateReducerTest, PassesTheBandWithExactDelayAndStopsTheRest) {
    for (const int n : {2, 3, 12, 24}) {
        for (double share = 0; share <= 0.3; share += 0.01)
            EXPECT_LT(std::abs(response(n, share) - 1.0), 2e-5) << n << " at " << share;
        for (double share = 0.7; share <= 0.5 * n; share += 0.03)
            EXPECT_LT(std::abs(response(n, share)), 2e-5) << n << " at " << share;
    }
    RateReducer none{1};
    none.add({0.25, -1, 3});
    EXPECT_EQ(none.delay(), 0);
    EXPECT_EQ(none.value(), (std::array<double, 3>{0.25, -1, 3}));
}

TEST(RateReducerTest, DoesNotAllocate) {
    RateReducer r{12};
    const test::NoAlloc none;
    double sum = 0;
    for (int i = 0; i < 1000; ++i) {
        r.add({1, 2, 3});
        sum += r.value()[0];
    }
    EXPECT_GT(sum, 0);
}

TEST(CodeTest, EveryFormatIsLeftJustified) {
    const std::array bytes{std::byte{0x11}, std::byte{0x22}, std::byte{0x33}, std::byte{0x84}};
    EXPECT_EQ(code_at(bytes.data(), alsa::SampleFormat::s16), 0x22110000);
    EXPECT_EQ(code_at(bytes.data(), alsa::SampleFormat::s24), 0x33221100);
    EXPECT_EQ(code_at(bytes.data(), alsa::SampleFormat::s24_3), 0x33221100);
    EXPECT_EQ(code_at(bytes.data(), alsa::SampleFormat::s32), static_cast<std::int32_t>(0x84332211));
}

/// A mock input that a thread feeds with 100 Hz of a quarter of full scale, at 48 kHz by the host's clock.
class FedLine {
public:
    FedLine() : epoch_{mock::host_now()}, line_{folder_ / "line", 48000, 48000, epoch_} {
        std::ofstream{folder_ / "asound.conf"}
            << "pcm_type.shaker_mock_line { lib \"" + test::build_dir() + "/shaker_mock_pcm.so\" }\n"
            << "pcm.line { type shaker_mock_line input \"" << (folder_ / "line").string() << "\" }\n";
        settings.pcm = "line";
        settings.alsa_config = folder_ / "asound.conf";
        settings.full_scale_V = 1;
        settings.mv_per_mps2 = 10;
        settings.shaker_axis = {1, 0, 0};
        feeder_ = std::jthread{[this](const std::stop_token& stop) {
            while (!stop.stop_requested()) {
                std::this_thread::sleep_for(2ms);
                feed();
            }
        }};
    }
    ~FedLine() {
        feeder_ = {};
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    [[nodiscard]] static double value(double at_s) { return 25 * std::sin(2 * pi * 100 * at_s); }  // m/s^2
    [[nodiscard]] double seconds_at(HostTime t) const { return Seconds{t - epoch_}.count(); }
    mock::LineInput& line() { return line_; }

    InputSettings settings;

private:
    void feed() {
        const auto due = static_cast<std::int64_t>(48000 * seconds_at(mock::host_now()));
        std::vector<std::array<std::int32_t, 2>> samples;
        for (; fed_ < due; ++fed_) {
            const double share = value(static_cast<double>(fed_) / 48000) / 100;
            samples.push_back({static_cast<std::int32_t>(std::lround(share * 0x7fffffff)), 0});
        }
        line_.put(samples);
    }
    static std::filesystem::path memory_folder() {
        std::string name = "/dev/shm/shaker-XXXXXX";
        if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error{"no temporary folder"};
        return name;
    }

    std::filesystem::path folder_ = memory_folder();
    HostTime epoch_;
    mock::LineInput line_;
    std::int64_t fed_ = 0;
    std::jthread feeder_;
};

AccelBlock next(Accelerometer& sensor) {
    AccelBlock block;
    for (int tries = 0; tries < 100; ++tries)
        if (sensor.read(block, 50ms)) return block;
    ADD_FAILURE() << "no block in 5 s";
    return block;
}

/// By how much the stamp of a block is later than its samples, s: the value at each time is known.
double late_s(const FedLine& fed, const AccelBlock& block, const AccelerometerInfo& info) {
    double ss = 0, sc = 0, cc = 0, as = 0, ac = 0;  // least squares: a block is no whole period
    const double last_s = fed.seconds_at(block.arrived);
    for (int i = 0; i < block.size; ++i) {
        const double at = last_s + (i - block.size + 1) / info.rate_hz;
        const double a = info.acceleration(block.counts[static_cast<std::size_t>(i)])[0];
        const double s = std::sin(2 * pi * 100 * at), c = std::cos(2 * pi * 100 * at);
        ss += s * s, sc += s * c, cc += c * c, as += a * s, ac += a * c;
    }
    return std::atan2(as * sc - ac * ss, as * cc - ac * sc) / (2 * pi * 100);
}

TEST(AlsaAccelerometerTest, SamplesAndTheirStampsAgree) {
    FedLine fed;
    fed.settings.period_frames = 96;
    hardware::Notes notes;
    const auto sensor = open_alsa_accelerometer(fed.settings, notes);
    const AccelerometerInfo info = sensor->info();
    EXPECT_EQ(info.rate_hz, 4000);
    EXPECT_EQ(info.axes, 1);
    EXPECT_FALSE(info.gravity);
    EXPECT_NEAR(info.range_mps2, 100, 1e-4);
    EXPECT_NE(notes.at(0).find("line: S32 at 48000 Hz"), std::string::npos) << notes.at(0);
    std::int64_t tick = next(*sensor).first.n + fed.settings.block_samples();
    double largest = 0, least_late_s = 1;
    for (int i = 0; i < 100; ++i) {
        const AccelBlock block = next(*sensor);
        ASSERT_EQ(block.first.n, tick);
        ASSERT_EQ(block.quality, Quality::good);
        EXPECT_EQ(block.counts[0][1], 0);
        tick += block.size;
        for (int k = 0; k < block.size; ++k)
            largest = std::max(largest, info.acceleration(block.counts[static_cast<std::size_t>(k)])[0]);
        least_late_s = std::min(least_late_s, late_s(fed, block, info));
    }
    // A stamp is late by what the feeder waits, and never early: the delay of the filter is in it.
    EXPECT_GT(least_late_s, -5e-5);
    EXPECT_LT(least_late_s, 6e-4);
    EXPECT_NEAR(largest, 25, 0.1);
    EXPECT_EQ(sensor->counts().lost, 0U);
    EXPECT_EQ(sensor->counts().taken, 101U * static_cast<unsigned>(fed.settings.block_samples()));
}

TEST(AlsaAccelerometerTest, AnOverrunIsAGapOfTheRightLength) {
    FedLine fed;
    hardware::Notes notes;
    const auto sensor = open_alsa_accelerometer(fed.settings, notes);
    AccelBlock before = next(*sensor);
    for (int i = 0; i < 20; ++i) before = next(*sensor);
    fed.line().cause_overrun();
    AccelBlock block = next(*sensor);
    while (!has(block.quality, Quality::gap)) before = std::exchange(block, next(*sensor));
    const double stamps_s = Seconds{block.arrived - before.arrived}.count();
    const auto ticks = block.first.n + block.size - before.first.n - before.size;
    EXPECT_NEAR(static_cast<double>(ticks) / 4000, stamps_s, 3e-3);  // the feeder makes stamps late by 2 ms
    EXPECT_GT(block.first.n, before.first.n + before.size);
    EXPECT_EQ(sensor->counts().lost,
              static_cast<std::uint64_t>(block.first.n - before.first.n - before.size));
    EXPECT_EQ(sensor->counts().incidents, 1U);
    EXPECT_EQ(sensor->counts().reopened, 0U);
}

// Other devices of the bench are opened between the opening of the input and its first sample.
TEST(AlsaAccelerometerTest, APauseBeforeTheFirstReadIsNoLoss) {
    FedLine fed;
    hardware::Notes notes;
    const auto sensor = open_alsa_accelerometer(fed.settings, notes);
    std::this_thread::sleep_for(700ms);  // longer than its buffer
    const AccelBlock first = next(*sensor);
    EXPECT_EQ(first.first.n, 0);
    EXPECT_EQ(first.quality, Quality::good);
    next(*sensor);
    EXPECT_EQ(sensor->counts().lost, 0U);
    EXPECT_EQ(sensor->counts().incidents, 0U);
}

// A range of the sensor's sheet beyond full scale of the input would never be reached.
TEST(AlsaAccelerometerTest, TheRangeEndsAtFullScale) {
    FedLine fed;
    hardware::Notes notes;
    fed.settings.range_mps2 = 490;
    EXPECT_NEAR(open_alsa_accelerometer(fed.settings, notes)->info().range_mps2, 100, 1e-4);
    fed.settings.range_mps2 = 49;
    EXPECT_EQ(open_alsa_accelerometer(fed.settings, notes)->info().range_mps2, 49);
}

TEST(AlsaAccelerometerTest, ADeviceThatReturnsIsOpenedAgain) {
    FedLine fed;
    hardware::Notes notes;
    const auto sensor = open_alsa_accelerometer(fed.settings, notes);
    next(*sensor);
    fed.line().unplug();
    AccelBlock block;
    for (int i = 0; i < 10; ++i) sensor->read(block, 50ms);
    fed.line().plug();
    for (int i = 0; i < 100 && !(sensor->read(block, 50ms) && has(block.quality, Quality::gap)); ++i) {
    }
    EXPECT_TRUE(has(block.quality, Quality::gap));
    EXPECT_EQ(sensor->counts().reopened, 1U);
    EXPECT_GT(sensor->counts().lost, 2000U);  // 0.5 s
}

TEST(AlsaAccelerometerTest, ADeviceThatStaysAwayIsAnError) {
    FedLine fed;
    fed.settings.give_up_s = 0.7;
    hardware::Notes notes;
    const auto sensor = open_alsa_accelerometer(fed.settings, notes);
    next(*sensor);
    fed.line().unplug();
    AccelBlock block;
    EXPECT_THROW(for (int i = 0; i < 60; ++i) sensor->read(block, 50ms), DeviceError);
}

TEST(AlsaAccelerometerTest, WhatTheDeviceCannotDoIsNamed) {
    FedLine fed;
    hardware::Notes notes;
    const auto words = [&](auto change) {
        InputSettings s = fed.settings;
        change(s);
        try {
            open_alsa_accelerometer(s, notes);
        } catch (const DeviceError& e) {
            return std::string{e.what()};
        }
        return std::string{"opened"};
    };
    EXPECT_NE(words([](InputSettings& s) {
                  s.rate_hz = 96000;
              }).find("rate_hz 96000 is not possible: it has 48000"),
              std::string::npos);
    EXPECT_NE(words([](InputSettings& s) { s.channels = {9}; }).find("channel 9 is not possible"),
              std::string::npos);
    EXPECT_NE(words([](InputSettings& s) { s.period_frames = 4800; }).find("periods of 4800"),
              std::string::npos);
    EXPECT_NE(words([](InputSettings& s) { s.full_scale_V.reset(); }).find("`full_scale_V` is required"),
              std::string::npos);
    EXPECT_NE(words([](InputSettings& s) { s.pcm = "not_there"; }).find("cannot be opened"),
              std::string::npos);
}

}  // namespace
}  // namespace shaker::alsa_input
