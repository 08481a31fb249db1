#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "drivers/hardware/alsa/output_frames.hpp"

namespace shaker::hardware {
namespace {

constexpr double full_scale_V = 2.5;

TEST(PcmCodecTest, CodeIsStepCountWithinFullScale) {
    const alsa::PcmCodec codec{alsa::SampleFormat::s32, 0, full_scale_V};
    constexpr std::int32_t most = (1 << 23) - 1;
    EXPECT_EQ(codec.bits(), 24);
    EXPECT_EQ(codec.code(0), 0);
    EXPECT_EQ(codec.code(full_scale_V / 2), 1 << 22);
    EXPECT_EQ(codec.code(-full_scale_V / 2), -(1 << 22));
    EXPECT_EQ(codec.code(full_scale_V), most);
    EXPECT_EQ(codec.code(-full_scale_V), -most);
    EXPECT_EQ(codec.code(std::numeric_limits<double>::infinity()), most);
    EXPECT_EQ(codec.code(-1e300), -most);
    EXPECT_EQ(codec.code(std::numeric_limits<double>::quiet_NaN()), 0);
    for (std::int64_t tick = 0; tick < 1000; ++tick)
        EXPECT_LE(std::abs(codec.dithered(-full_scale_V, {tick}, 0)), most);
}

TEST(PcmCodecTest, AConverterOfFewerBitsGetsItsOwnSteps) {
    const alsa::PcmCodec codec{alsa::SampleFormat::s32, 20, full_scale_V};
    EXPECT_EQ(codec.bits(), 20);
    std::array<std::byte, 4> bytes{};
    codec.put(bytes.data(), codec.code(full_scale_V / 2));
    EXPECT_EQ(bytes, (std::array{std::byte{0}, std::byte{0}, std::byte{0}, std::byte{0x40}}));
}

TEST(PcmCodecTest, BytesAreLittleEndianAndSigned) {
    std::array<std::byte, 4> bytes{};
    const auto minus_two = [&](alsa::SampleFormat format) {
        bytes = {};
        alsa::PcmCodec{format, 0, 1}.put(bytes.data(), -2);
        return bytes;
    };
    constexpr std::byte z{0}, fe{0xfe}, ff{0xff};
    EXPECT_EQ(minus_two(alsa::SampleFormat::s32), (std::array{z, fe, ff, ff}));
    EXPECT_EQ(minus_two(alsa::SampleFormat::s24), (std::array{fe, ff, ff, ff}));
    EXPECT_EQ(minus_two(alsa::SampleFormat::s24_3), (std::array{fe, ff, ff, z}));
    EXPECT_EQ(minus_two(alsa::SampleFormat::s16), (std::array{fe, ff, z, z}));
}

// Triangular dither makes mean and variance of the error those of no signal: 0 and 1/4 step squared (1/12 of
// rounding and twice 1/12 of noise). 1e5 samples give the mean to 0.0016, the variance to 0.0011: 5 sigma.
TEST(PcmCodecTest, DitheredErrorIsIndependentOfSignal) {
    const alsa::PcmCodec codec{alsa::SampleFormat::s16, 0, 32768};  // 1 V a step
    constexpr int n = 100000;
    for (const double volts : {0.0, 0.25, 0.5, 1.7}) {
        double sum = 0, squares = 0;
        for (std::int64_t i = 0; i < n; ++i) {
            const double error = codec.dithered(volts, {i}, 0) - volts;
            sum += error;
            squares += error * error;
        }
        EXPECT_NEAR(sum / n, 0, 0.008) << volts;
        EXPECT_NEAR(squares / n, 0.25, 0.006) << volts;
    }
}

TEST(PcmCodecTest, DitherIsAFunctionOfTickAndChannelAlone) {
    const alsa::PcmCodec codec{alsa::SampleFormat::s16, 0, 32768};
    const alsa::PcmCodec other{alsa::SampleFormat::s16, 0, 32768};
    int same = 0;
    constexpr int n = 100000;
    for (std::int64_t i = 0; i < n; ++i) {
        ASSERT_EQ(codec.dithered(0.3, {i}, 0), other.dithered(0.3, {i}, 0));
        if (codec.dithered(0.5, {i}, 0) == codec.dithered(0.5, {i}, 1)) ++same;
    }
    // Half a step becomes 0 or 1 with equal probability; independent channels agree in half of the samples,
    // within 5 sigma.
    EXPECT_NEAR(same, 0.5 * n, 800);
}

}  // namespace
}  // namespace shaker::hardware
