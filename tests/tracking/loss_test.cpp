// A lost target in a wide picture: found again wherever it is, by searches of bounded cost.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/cost.hpp"
#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker::tracking {
namespace {

constexpr int width = 1280, height = 256;
constexpr Point begins{508.3, 127.8};

View wide_view(const Target& target) {
    View view;
    view.camera = "wide";
    view.mm_per_px = 0.25;
    view.targets = {target};
    return view;
}

View disc_in_wide_picture(double radius) {
    Target disc{"disc", TargetKind::disc};
    disc.diameter_mm = 0.5 * radius;
    const int half = static_cast<int>(radius) + 8;
    disc.roi_px = {508 - half, 128 - half, 2 * half, 2 * half};
    return wide_view(disc);
}

View texture_in_wide_picture() {
    Target patch{"patch", TargetKind::patch};
    patch.roi_px = {460, 96, 96, 64};
    return wide_view(patch);
}

test::Shot wide_picture(double radius, Point at, std::mt19937_64& random) {
    test::TestPicture p{width, height, 60};
    p.disc(at, radius, 160, 0.8);
    return p.expose({.noise = 3}, random);
}

// A textured plate of 120 x 88 px.
test::Shot wide_texture(Point at, std::mt19937_64& random) {
    test::TestPicture p{width, height, 120};
    const int x = static_cast<int>(std::lround(at.x)), y = static_cast<int>(std::lround(at.y));
    p.texture({std::max(0, x - 60), std::max(0, y - 44), std::min(width, x + 60), std::min(height, y + 44)},
              at - begins, 25, 11);
    return p.expose({.noise = 3}, random);
}

constexpr double texture = 0;

struct LossCase {
    double radius;      // px, of a disc; or `texture`
    int most_pictures;  // until it is found
    /// Where the tracker reports what is drawn at `at`, px. It follows a texture by the middle of its region.
    [[nodiscard]] double x_at(Point at) const { return radius == texture ? at.x - begins.x + 507.5 : at.x; }
    [[nodiscard]] View view() const {
        return radius == texture ? texture_in_wide_picture() : disc_in_wide_picture(radius);
    }
    [[nodiscard]] test::Shot shot(Point at, std::mt19937_64& random) const {
        return radius == texture ? wide_texture(at, random) : wide_picture(radius, at, random);
    }
    friend std::ostream& operator<<(std::ostream& out, const LossCase& c) { return out << c.radius << " px"; }
};

class LossTest : public testing::TestWithParam<LossCase> {};

// Away from its last place it may take a sweep over the whole picture, in parts if the disc is small.
TEST_P(LossTest, IsFoundAgainAnywhereAndAlikeInEachReplay) {
    const LossCase& c = GetParam();
    std::mt19937_64 random{4};
    const test::Shot first = c.shot(begins, random), none = c.shot({-999, 0}, random);
    test::Follower one{c.view()}, other{c.view()};
    for (const Point at : {Point{900.4, 140.2}, {130.9, 118.5}, {1228.6, 120.1}}) {
        const test::Shot again = c.shot(at, random);
        for (test::Follower* follow : {&one, &other}) (*follow)(first);
        for (int i = 0; i < 5; ++i) {
            EXPECT_EQ(one(none).state, TrackState::lost);
            other(none);
        }
        int pictures = 0;
        Fix fix;
        while (!found(fix.state) && pictures <= c.most_pictures) {
            fix = one(again);
            EXPECT_EQ(std::isfinite(fix.x_px), found(fix.state));
            const Fix same = other(again);
            EXPECT_TRUE(same.state == fix.state && (!found(fix.state) || same.x_px == fix.x_px));
            ++pictures;
        }
        EXPECT_LE(pictures, c.most_pictures) << "at " << at.x;
        EXPECT_NEAR(fix.x_px, c.x_at(at), 0.1);
        fix = {};
        for (int i = 0; i < 40 && !found(fix.state); ++i) {
            fix = one(first);
            other(first);
        }
    }
}

// Processor time beside that of one pass over the picture's pixels; a search of the whole picture at its full
// size costs forty.
TEST_P(LossTest, ALostPictureCostsAtMostFourPassesOverIt) {
    const LossCase& c = GetParam();
    std::mt19937_64 random{4};
    const test::Shot seen = c.shot(begins, random), none = c.shot({-999, 0}, random);
    test::Follower follow{c.view()};
    follow(seen);
    const double lost = bench::median_cost_ns(31, [&] { EXPECT_FALSE(found(follow(none).state)); });
    volatile unsigned sum = 0;
    const double pass = bench::median_cost_ns(31, [&] {
        for (const std::byte b : none.pixels) sum = sum + static_cast<unsigned>(b);
    });
    RecordProperty("lost_us", std::to_string(1e-3 * lost));
    EXPECT_LT(lost, 4 * pass) << "ns; a pass " << pass;
}

INSTANTIATE_TEST_SUITE_P(Tracking, LossTest,
                         testing::Values(LossCase{100, 2}, LossCase{30, 9}, LossCase{6, 24},
                                         LossCase{texture, 40}),
                         [](const auto& p) {
                             if (p.param.radius == texture) return std::string{"Texture"};
                             return "Radius" + std::to_string(static_cast<int>(p.param.radius));
                         });

// Bumps of a strong texture resemble a lost dot; none is taken for it. Where they resemble it too much, the
// dot stays lost instead.
TEST(ClutterTest, NoBumpOfTheGroundIsTakenForALostDot) {
    for (const double rms : {10.0, 25.0}) {
        std::mt19937_64 random{4};
        test::TestPicture ground{width, height, 90};
        ground.texture({0, 0, width, height}, {0, 0}, rms, 21);
        const auto shot = [&](Point at) {
            test::TestPicture p = ground;
            p.disc(at, 6, 200, 0.8);
            return p.expose({.noise = 3}, random);
        };
        test::Follower follow{disc_in_wide_picture(6)};
        follow(shot(begins));
        int taken = 0, until_found = 0;
        for (int i = 0; i < 60; ++i) taken += found(follow(shot({-99, 0})).state);
        Fix fix;
        while (!found(fix.state) && until_found < 40) {
            fix = follow(shot({700.4, 140.2}));
            ++until_found;
        }
        std::printf("clutter of %g grey levels rms: %d of 60 bumps taken, found again after %d pictures\n",
                    rms, taken, until_found);
        EXPECT_EQ(taken, 0) << rms;
        if (rms < 20) {
            EXPECT_NEAR(fix.x_px, 700.4, 0.5) << rms;
        }
    }
}

// A disc of 600 px in the same picture shows two arcs.
TEST(ArcsTest, AreFoundAgainInTwoPictures) {
    const test::TrackingScene& scene = test::tracking_scene("paper");
    std::mt19937_64 random{4};
    test::Follower follow{scene.view};
    follow(scene.picture({0, 0}).expose({.noise = 3}, random));
    const test::Shot none = test::TestPicture{width, height, 70}.expose({.noise = 3}, random);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(follow(none).state, TrackState::lost);
    const test::Shot again = scene.picture({120.4, 0}).expose({.noise = 3}, random);
    follow(again);
    const Fix fix = follow(again);
    ASSERT_TRUE(found(fix.state));
    EXPECT_NEAR(fix.x_px, 640.3 + 120.4, 0.1);
}

// What a part of a target used to show in the light of before does not keep it lost.
TEST(LossTest, IsFoundAgainInLightFromTheOtherSide) {
    for (const char* name : {"disc", "dot", "arcs", "rectangle", "dots", "bars"}) {
        const test::TrackingScene& scene = test::tracking_scene(name);
        std::mt19937_64 random{5};
        test::Follower follow{scene.view};
        const double slope = 1.2;  // of the light over the width of the picture
        double origin = 0;
        int found_at = -1;
        for (int i = 0; i < 110; ++i) {
            const double shift = 0.3 * std::sin(0.3 * i);
            test::TestPicture picture = scene.picture({shift, 0});
            picture.light(0.8, i < 50 ? -slope : slope);
            if (i >= 50 && i < 60) picture.cover({0, 0, picture.width(), picture.height()}, 70);
            const Fix fix = follow(picture.expose({.noise = 3}, random));
            if (i < 50) origin += (fix.x_px - shift) / 50;
            if (i < 60 || !found(fix.state)) continue;
            if (found_at < 0) found_at = i;
            EXPECT_LT(std::abs(fix.x_px - shift - origin), 0.3) << name << ", frame " << i;
        }
        EXPECT_GE(found_at, 60) << name;
        EXPECT_LE(found_at, 70) << name;
    }
}

}  // namespace
}  // namespace shaker::tracking
