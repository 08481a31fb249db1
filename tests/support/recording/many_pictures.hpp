#pragma once
// Pictures whose pixels follow from the picture's number, and checks of stored pictures.
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/recorded/pictures/picture_record.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker::test {

/// Picture `number`, from 1, with stamps and qualities of every kind.
inline Frame numbered(std::uint64_t number, const pictures::PictureShape& shape) {
    const auto n = static_cast<std::int64_t>(number);
    Frame f;
    f.tick = {3 * n - 1};
    f.arrived = HostTime{std::chrono::nanoseconds{1'000'000'007 * n}};
    if (number % 3 != 0) f.stamp = CameraStamp{number % 5 == 0 ? -n : n << 40U};
    if (number % 4 != 0) f.mid_exposure = master_time(0.001 * static_cast<double>(n) + 1e-17);
    f.quality = static_cast<Quality>(number % 8);
    f.width = shape.width;
    f.height = shape.height;
    f.bytes_per_pixel = shape.bytes_per_pixel;
    f.pixels.resize(shape.bytes());
    std::uint64_t state = number * 0x9E3779B97F4A7C15U + 1;
    for (std::byte& b : f.pixels) {
        state ^= state << 13U;
        state ^= state >> 7U;
        state ^= state << 17U;
        b = static_cast<std::byte>(state >> 56U);
    }
    return f;
}

inline void expect_same(const Frame& a, const Frame& b, std::uint64_t number) {
    EXPECT_EQ(a.tick, b.tick) << number;
    EXPECT_EQ(a.arrived, b.arrived) << number;
    EXPECT_EQ(a.stamp, b.stamp) << number;
    EXPECT_EQ(a.mid_exposure, b.mid_exposure) << number;
    EXPECT_EQ(a.quality, b.quality) << number;
    EXPECT_EQ(a.width, b.width) << number;
    EXPECT_EQ(a.height, b.height) << number;
    EXPECT_EQ(a.bytes_per_pixel, b.bytes_per_pixel) << number;
    EXPECT_TRUE(a.pixels == b.pixels) << "pixels of picture " << number;
}

}  // namespace shaker::test
