// Pictures that are delivered twice, or torn: found where noise shows them, and nowhere else.
#include "tracking/old_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "tests/support/tracking/test_picture.hpp"

namespace shaker::tracking {
namespace {

using test::Shot, test::TestPicture;

/// A bright disc that swings, and noise.
Shot shot_of(int i, std::mt19937_64& random, double noise, int width = 160, int height = 96, int bytes = 1) {
    TestPicture p{width, height, 60};
    p.disc({0.5 * width + 3 * std::sin(0.3 * i), 0.5 * height}, 0.3 * height, 170, 0.8);
    return p.expose({.bytes_per_pixel = bytes,
                     .noise = noise,
                     .depth = bytes == 2 ? 16.0 : 1,
                     .full = bytes == 2 ? 4095.0 : 255},
                    random);
}

/// `from` to the end is that of another picture.
Shot torn(Shot shot, const Shot& other, double from) {
    const auto at = static_cast<std::ptrdiff_t>(from * shot.height) * shot.stride;
    std::copy(other.pixels.begin() + at, other.pixels.end(), shot.pixels.begin() + at);
    return shot;
}

/// Copies what does not move, as a movie does: the rows above and below the disc.
Shot still_about(Shot shot, const Shot& before) {
    const auto part = std::ssize(shot.pixels) / 8;
    std::copy(before.pixels.begin(), before.pixels.begin() + part, shot.pixels.begin());
    std::copy(before.pixels.end() - part, before.pixels.end(), shot.pixels.end() - part);
    return shot;
}

int found_old(int pictures, double noise, int width, int height, int bytes) {
    std::mt19937_64 random{4};
    OldRows rows;
    int old = 0;
    for (int i = 0; i < pictures; ++i) old += rows.in(shot_of(i, random, noise, width, height, bytes).view());
    return old;
}

TEST(OldRowsTest, NewPicturesAreNotOld) {
    for (const double noise : {0.0, 0.25, 0.5, 1.0, 4.0})
        for (const auto& [width, height] : {std::pair{160, 96}, {4, 200}, {16, 64}, {40, 5}, {200, 4}})
            for (const int bytes : {1, 2})
                EXPECT_EQ(found_old(120, noise, width, height, bytes), 0)
                    << width << " x " << height << ", noise " << noise << ", " << bytes << " bytes";
}

TEST(OldRowsTest, RepeatedAndTornPicturesAreOld) {
    for (const int bytes : {1, 2})
        for (const int times : {2, 3, 4}) {
            std::mt19937_64 random{4};
            OldRows rows;
            int missed = 0;
            for (int i = 0; i < 100; ++i) {
                const Shot shot = shot_of(i, random, 1, 160, 96, bytes);
                EXPECT_FALSE(rows.in(shot.view())) << "picture " << i << ", " << times << " times";
                for (int k = 1; k < times; ++k) missed += !rows.in(shot.view());
            }
            EXPECT_LE(missed, 16 * (times - 1)) << "until the noise is known";
        }
    std::mt19937_64 random{4};
    OldRows rows;
    Shot before = shot_of(0, random, 1);
    for (int i = 1; i < 100; ++i) {
        Shot shot = shot_of(i, random, 1);
        const bool tears = i > 20 && i % 3 == 0;
        if (tears) shot = torn(shot, before, 0.2 + 0.006 * i);
        EXPECT_EQ(rows.in(shot.view()), tears) << i;
        before = shot;
    }
}

TEST(OldRowsTest, ACoveredLensIsNotOld) {
    std::mt19937_64 random{4};
    OldRows rows;
    for (int i = 0; i < 30; ++i) rows.in(shot_of(i, random, 1).view());
    for (int i = 0; i < 60; ++i)
        EXPECT_FALSE(rows.in(TestPicture(160, 96, 0).expose({}, random).view())) << i;
}

TEST(OldRowsTest, AFrozenCameraStaysOld) {
    std::mt19937_64 random{4};
    OldRows rows;
    Shot shot;
    for (int i = 0; i < 30; ++i) rows.in((shot = shot_of(i, random, 1)).view());
    for (int i = 0; i < 200; ++i) EXPECT_TRUE(rows.in(shot.view()));
    EXPECT_FALSE(rows.in(shot_of(1, random, 1).view()));
}

// Without noise a target at rest gives equal pictures; so does a movie whose still parts are not coded again.
TEST(OldRowsTest, StillPicturesWithoutNoiseAreNotOld) {
    std::mt19937_64 random{4};
    OldRows texture, grain, layers, movie;
    Shot before = shot_of(0, random, 1);
    const Shot still = shot_of(0, random, 1);
    for (int i = 0; i < 200; ++i) {
        TestPicture p{160, 96, 120};
        p.texture({0, 0, 160, 96}, {3 * std::sin(0.3 * std::min(i, 120)), 0}, 30, 5);
        EXPECT_FALSE(texture.in(p.expose({}, random).view())) << "texture, picture " << i;
        TestPicture fine{160, 96, 120};  // a grain of 2 px, at rest from picture 120 on
        std::mt19937_64 grains{3};
        for (int k = 0; k < 1500; ++k) {
            const auto at = [&](int size) { return std::uniform_real_distribution<double>(0, size)(grains); };
            const double x = at(160), y = at(96);
            fine.disc({x + 3 * std::sin(0.3 * std::min(i, 120)), y}, 1, at(255), 0.4);
        }
        EXPECT_FALSE(grain.in(fine.expose({}, random).view())) << "grain, picture " << i;
        const Shot next = shot_of(i, random, 1);
        EXPECT_FALSE(layers.in((i % 2 == 0 ? next : still_about(next, before)).view()))
            << "layers, picture " << i;
        before = next;
        Shot coded = torn(shot_of(i, random, i % 12 == 0 ? 1 : 0), still, 0.6);
        if (i % 12 == 0) coded = shot_of(i, random, 1);
        EXPECT_FALSE(movie.in(coded.view())) << "movie, picture " << i;
    }
}

}  // namespace
}  // namespace shaker::tracking
