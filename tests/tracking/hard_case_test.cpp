// Targets that are partly or fully hidden, and regions refused at the start.
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/errors.hpp"
#include "tests/support/tracking/tracking_scene.hpp"
#include "tracking/image/region.hpp"

namespace shaker::tracking {
namespace {

using test::Follower, test::TestPicture, test::TrackingScene;

class HardCaseTest : public testing::TestWithParam<std::string> {
protected:
    const TrackingScene& scene_ = test::tracking_scene(GetParam());
    std::mt19937_64 random_{5};
    [[nodiscard]] test::Shot shot(const TestPicture& picture) {
        return picture.expose({.noise = 3}, random_);
    }

    /// An error must be within four claimed standard deviations, or flagged with a claim of at least half of
    /// it.
    static void expect_honest(const Fix& fix, double error, int frame) {
        if (!found(fix.state)) {
            EXPECT_TRUE(std::isnan(fix.x_px) && std::isnan(fix.y_px) && std::isnan(fix.sd_px));
            return;
        }
        ASSERT_TRUE(std::isfinite(fix.x_px) && std::isfinite(fix.y_px) && fix.sd_px > 0) << "frame " << frame;
        if (fix.state == TrackState::ok) {
            EXPECT_LT(std::abs(error), 4 * fix.sd_px) << "frame " << frame;
        }
    }

    /// Mean place over the first frames in full view, the reference for later frames.
    double settle(Follower& follow) {
        double sum = 0;
        for (int i = 0; i < 16; ++i) sum += follow(shot(scene_.picture({0, 0}))).x_px / 16;
        return sum;
    }
};

// The view is dark grey for ten frames: none of them may count as found, and the second frame after them
// must.
TEST_P(HardCaseTest, RecoversWithinTwoFramesAfterCover) {
    Follower follow{scene_.view};
    const double origin = settle(follow);
    for (int i = 0; i < 40; ++i) {
        const double shift = 1.2 * std::sin(0.2 * i);
        TestPicture picture = scene_.picture({shift, 0});
        const bool covered = i >= 10 && i < 20;
        if (covered) picture.cover({0, 0, picture.width(), picture.height()}, 70);
        const Fix fix = follow(shot(picture));
        if (covered) {
            EXPECT_EQ(fix.state, TrackState::lost) << "frame " << i;
        }
        if (i == 20) {
            EXPECT_TRUE(fix.state == TrackState::lost || fix.state == TrackState::reacquired);
        }
        if (!covered && i != 20) {
            EXPECT_TRUE(found(fix.state)) << "frame " << i;
        }
        if (found(fix.state)) {
            EXPECT_LT(std::abs(fix.x_px - shift - origin), 0.2) << "frame " << i;
        }
    }
}

// A card slides completely over the target from the left and away again. No wrong place is reported.
TEST_P(HardCaseTest, ReportsNoWrongPositionUnderSlidingCard) {
    Follower follow{scene_.view};
    const double origin = settle(follow);
    int last_found = -1;
    for (int i = 0; i < 60; ++i) {
        TestPicture picture = scene_.picture({0, 0});
        const int edge = scene_.width * (i < 30 ? i : 59 - i) / 24;
        picture.cover({0, 0, edge, scene_.height}, 110);
        const Fix fix = follow(shot(picture));
        const double error = fix.x_px - origin;
        expect_honest(fix, error, i);
        if (found(fix.state)) {
            EXPECT_LT(std::abs(error), 0.5) << "frame " << i;
            last_found = i;
        }
    }
    EXPECT_EQ(last_found, 59);
}

TEST_P(HardCaseTest, IsDegradedUnderHighlightOrQuarterHidden) {
    Follower follow{scene_.view};
    const double origin = settle(follow);
    const auto& roi = scene_.view.targets.front().roi_px;
    for (int i = 0; i < 60; ++i) {
        const double shift = 1.5 * std::sin(0.4 * i);
        TestPicture picture = scene_.picture({shift, 0});
        const double size = 0.08 * roi[2];
        picture.disc({roi[0] + 0.3 * roi[2], roi[1] + 0.3 * roi[3]}, size, 400, 1);
        picture.cover({roi[0] + 3 * roi[2] / 4, 0, roi[0] + roi[2], scene_.height}, 90);
        const Fix fix = follow(shot(picture));
        expect_honest(fix, fix.x_px - shift - origin, i);
    }
}

// Light that falls on a target from one side moves it by what its slope leaves unfitted. Where the light goes
// back, so does the target, within as many pictures as its slope is learned from, and a few more.
TEST_P(HardCaseTest, LightThatIsEvenAgainMovesItNoMore) {
    Follower follow{scene_.view};
    constexpr int even = 30, tilted = 30, settling = 16;
    double before = 0, after = 0, sd = 0;
    for (int i = 0; i < 2 * even + tilted + settling; ++i) {
        TestPicture picture = scene_.picture({0, 0});
        if (i >= even && i < even + tilted) picture.light(1, 0.4);
        const Fix fix = follow(shot(picture));
        ASSERT_TRUE(found(fix.state)) << "picture " << i;
        if (i < even) before += fix.x_px / even;
        if (i >= even + tilted + settling) after += fix.x_px / even, sd = fix.sd_px;
    }
    EXPECT_NEAR(after, before, 3.5 * sd * std::sqrt(2.0 / even));
}

TEST_P(HardCaseTest, RefusesRegionOutsideTheImage) {
    View view = scene_.view;
    view.targets.front().roi_px = {scene_.width - 10, 0, 40, 30};
    const test::Shot frame = shot(scene_.picture({0, 0}));
    ViewTracker tracker{view};
    try {
        tracker.update(frame.view(), {});
        FAIL() << "accepted";
    } catch (const InputError& e) {
        const std::string words = e.what();
        EXPECT_NE(words.find("camera test"), std::string::npos) << words;
        EXPECT_NE(words.find("target " + scene_.name), std::string::npos) << words;
        EXPECT_NE(words.find("roi_px [" + std::to_string(scene_.width - 10)), std::string::npos) << words;
    }
}

TEST(RegionTest, IsClippedAtTheEdgeOfTheImage) {
    View view;
    view.mm_per_px = 0.25;
    const ImageView image{nullptr, 512, 144, 512, 1};
    const auto region = [&](std::array<int, 4> roi) {
        Target target;
        target.roi_px = roi;
        return region_in(subject_of(view, target), image);
    };
    const Box over = region({95, 20, 165, 125});  // ends one row below the image
    EXPECT_EQ((std::array{over.x0, over.y0, over.x1, over.y1}), (std::array{95, 20, 260, 144}));
    const Box left = region({-10, -5, 40, 40});
    EXPECT_EQ((std::array{left.x0, left.y0, left.x1, left.y1}), (std::array{0, 0, 30, 35}));
    constexpr int huge = std::numeric_limits<int>::max();
    for (const std::array<int, 4>& roi :
         {std::array{500, 0, 40, 30}, std::array{-30, 0, 40, 30}, std::array{5000, 20, 165, 125},
          std::array{0, 0, huge, huge}, std::array{-huge, -huge, huge, huge}})
        EXPECT_THROW(region(roi), InputError) << roi[0];
}

TEST_P(HardCaseTest, RefusesTooSmallOrEmptyRegion) {
    const test::Shot frame = shot(scene_.picture({0, 0}));
    View small = scene_.view;
    small.targets.front().roi_px[2] = 3;
    EXPECT_THROW(ViewTracker{small}.update(frame.view(), {}), InputError);
    std::mt19937_64 random{1};
    const test::Shot blank = TestPicture{scene_.width, scene_.height, 100}.expose({}, random);
    EXPECT_THROW(ViewTracker{scene_.view}.update(blank.view(), {}), InputError);
    if (scene_.name == "patch") return;  // noise is a texture
    const test::Shot noise = TestPicture{scene_.width, scene_.height, 100}.expose({.noise = 5}, random);
    EXPECT_THROW(ViewTracker{scene_.view}.update(noise.view(), {}), InputError);
}

TEST_P(HardCaseTest, RefusesPictureOfChangedSize) {
    Follower follow{scene_.view};
    const test::Shot frame = shot(scene_.picture({0, 0}));
    follow(frame);
    test::Shot cut = frame;
    cut.height -= 1;
    EXPECT_THROW(follow(cut), InputError);
}

INSTANTIATE_TEST_SUITE_P(Tracking, HardCaseTest,
                         testing::Values("disc", "dot", "arcs", "rectangle", "dots", "bars", "patch", "code"),
                         [](const auto& kind) { return kind.param; });

// A lever: the patch turns by up to 0.15 rad about a point that is 30 px beside its middle, in quiet pictures
// and in noisy ones.
TEST(TurningTest, APatchThatTurnsIsInDoubtBeforeItIsWrong) {
    const TrackingScene& scene = test::tracking_scene("patch");
    for (const double noise : {1.0, 3.0, 8.0}) {
        Follower follow{scene.view};
        std::mt19937_64 random{3};
        double origin = 0;
        int doubted = 0, sharp = 0;
        constexpr int still = 16, pictures = 200;
        for (int i = 0; i < pictures; ++i) {
            const double turn =
                i < still ? 0 : 0.15 * std::sin(std::numbers::pi * (i - still) / (pictures - still));
            const Point shift{30 * (1 - std::cos(turn)), 30 * std::sin(turn)};
            const Fix fix = follow(scene.picture(shift, {.turn = turn}).expose({.noise = noise}, random));
            if (i < still) {
                ASSERT_EQ(fix.state, TrackState::ok);
                origin += fix.x_px / still;
            }
            if (i < still || !found(fix.state)) continue;
            const double error = std::abs(fix.x_px - shift.x - origin);
            EXPECT_LT(error, 4 * fix.sd_px + 0.01) << "noise " << noise << ", turned by " << turn << " rad";
            doubted += doubtful(fix.state);
            sharp += turn > 0.1 && !doubtful(fix.state);
        }
        EXPECT_GT(doubted, 0);
        EXPECT_EQ(sharp, 0) << "noise " << noise;
    }
}

// 4 px per frame out of the picture on the right and back, with the rim partly cut on the way.
TEST(LeavingTest, LeavingDiscIsLostAndFoundAgain) {
    const TrackingScene& scene = test::tracking_scene("disc");
    Follower follow{scene.view};
    std::mt19937_64 random{3};
    double origin = 0;
    int lost = 0;
    for (int i = 0; i < 150; ++i) {
        const double shift = i < 75 ? 4.0 * i : 4.0 * (149 - i);
        const Fix fix = follow(scene.picture({shift, 0}).expose({.noise = 3}, random));
        if (i == 0) origin = fix.x_px;
        lost += found(fix.state) ? 0 : 1;
        const double right = origin + shift + 50;
        if (origin + shift - 50 > scene.width + 2) {
            EXPECT_EQ(fix.state, TrackState::lost) << "frame " << i;
        }
        if (right < scene.width - 8) {
            EXPECT_TRUE(found(fix.state)) << "frame " << i;
        }
        if (found(fix.state)) {
            EXPECT_LT(std::abs(fix.x_px - shift - origin), 0.3) << "frame " << i;
        }
    }
    EXPECT_GT(lost, 30);
    EXPECT_LT(lost, 100);
}

TEST(LengthTest, MeasuresLengthsThatAreNotGiven) {
    for (const std::string name : {"disc", "dot", "rectangle", "bars"}) {
        const TrackingScene& scene = test::tracking_scene(name);
        View unknown = scene.view;
        Target& target = unknown.targets.front();
        target.diameter_mm = target.width_mm = target.pitch_mm = 0;
        std::mt19937_64 random{2};
        const test::Shot frame = scene.picture({0, 0}).expose({.noise = 2}, random);
        const Fix measured = Follower{unknown}(frame), given = Follower{scene.view}(frame);
        EXPECT_NEAR(measured.x_px, given.x_px, 0.02) << name;
    }
}

TEST(LengthTest, ALengthWrongByThreePercentIsMended) {
    for (const std::string name : {"disc", "dot", "arcs", "paper", "twin", "rectangle", "dots", "bars"}) {
        const TrackingScene& scene = test::tracking_scene(name);
        std::mt19937_64 random{2};
        const test::Shot frame = scene.picture({0, 0}).expose({.noise = 3}, random);
        const Fix right = Follower{scene.view}(frame);
        for (const double factor : {0.97, 0.985, 1.015, 1.03}) {
            View wrong = scene.view;
            Target& target = wrong.targets.front();
            for (double* length : {&target.diameter_mm, &target.width_mm, &target.pitch_mm})
                *length *= factor;
            const Fix fix = Follower{wrong}(frame);
            EXPECT_EQ(fix.state, TrackState::ok) << name << " times " << factor;
            EXPECT_NEAR(fix.x_px, right.x_px, 2 * right.sd_px) << name << " times " << factor;
        }
    }
}

// 600 px wide: 3 % of it is more than the coarse search reaches at one size.
TEST(LengthTest, AWideRectangleToldThreePercentWrongIsMendedToo) {
    std::mt19937_64 random{2};
    TestPicture p{1280, 256, 60};
    p.rectangle(340.3, 40, 940.3, 239, 160, 0.8);
    const test::Shot frame = p.expose({.noise = 3}, random);
    for (const double factor : {0.97, 1.0, 1.03}) {
        View view = test::tracking_scene("rectangle").view;
        view.targets.front().width_mm = 150 * factor;
        view.targets.front().roi_px = {320, 20, 640, 220};
        const Fix fix = Follower{view}(frame);
        EXPECT_EQ(fix.state, TrackState::ok) << factor;
        EXPECT_NEAR(fix.x_px, 640.3, 0.02) << factor;
    }
}

TEST(LengthTest, AMendedLengthIsTold) {
    for (const std::string name : {"disc", "rectangle", "dots", "bars"}) {
        const TrackingScene& scene = test::tracking_scene(name);
        std::mt19937_64 random{2};
        const test::Shot frame = scene.picture({0, 0}).expose({.noise = 3}, random);
        for (const double factor : {0.97, 1.0, 1.03}) {
            View view = scene.view;
            Target& target = view.targets.front();
            for (double* length : {&target.diameter_mm, &target.width_mm, &target.pitch_mm})
                *length *= factor;
            ViewTracker tracker{view};
            tracker.update(frame.view(), {});
            const auto told = tracker.corrections();
            if (factor == 1.0) {
                EXPECT_TRUE(told.empty()) << told.front();
                continue;
            }
            ASSERT_EQ(told.size(), 1U) << name << " times " << factor;
            const char* const how = factor < 1 ? "too small" : "too large";
            EXPECT_NE(told.front().find(how), std::string::npos) << told.front();
            EXPECT_NE(told.front().find("camera test, target"), std::string::npos) << told.front();
        }
    }
}

// A strip outside of the region hides a third of the disc's rim.
TEST(RegionTest, WhatLiesOutsideOfItDoesNotRefuseTheTarget) {
    std::mt19937_64 random{2};
    View view = test::tracking_scene("disc").view;
    view.targets.front().diameter_mm = 75;
    view.targets.front().roi_px = {340, 8, 320, 208};
    const auto shot = [&](double x) {
        TestPicture p{1000, 320, 60};
        p.disc({x, 165}, 150, 160, 0.8);
        p.cover({0, 216, 1000, 320}, 90);
        p.bars(500.2 + 0.5 * (x - 500), 16, 216, 320, 60, 160, 0.8);
        return p.expose({.noise = 3}, random);
    };
    Follower follow{view};
    follow(shot(500));
    for (const double x : {500.3, 500.9, 502.0, 503.1}) {
        const Fix fix = follow(shot(x));
        EXPECT_EQ(fix.state, TrackState::ok) << x;
        EXPECT_NEAR(fix.x_px, x, 0.05) << x;
    }
}

TEST(LengthTest, AWrongLengthIsRefused) {
    std::mt19937_64 random{2};
    for (const std::string name : {"disc", "rectangle", "dots", "bars"}) {
        const TrackingScene& scene = test::tracking_scene(name);
        View wrong = scene.view;
        Target& target = wrong.targets.front();
        target.diameter_mm *= 1.6;
        target.width_mm *= 1.6;
        target.pitch_mm *= 1.6;
        const test::Shot frame = scene.picture({0, 0}).expose({.noise = 2}, random);
        EXPECT_THROW(ViewTracker{wrong}.update(frame.view(), {}), InputError) << name;
    }
}

TEST(DirectionTest, OneDirectionKindsRefuseDiagonalAxis) {
    std::mt19937_64 random{2};
    for (const std::string name : {"rectangle", "bars", "code"}) {
        const TrackingScene& scene = test::tracking_scene(name);
        View diagonal = scene.view;
        diagonal.along = {std::sqrt(0.5), std::sqrt(0.5)};
        const test::Shot frame = scene.picture({0, 0}).expose({.noise = 2}, random);
        EXPECT_THROW(ViewTracker{diagonal}.update(frame.view(), {}), InputError) << name;
    }
}

// The same picture turned by 90 degrees, measured along y, gives the same number.
TEST(DirectionTest, BarsAndRectanglesAreMeasuredAlongYToo) {
    for (const std::string name : {"rectangle", "bars", "code"}) {
        const TrackingScene& scene = test::tracking_scene(name);
        View upright = scene.view;
        upright.along = {0, -1};
        auto& roi = upright.targets.front().roi_px;
        roi = {roi[1], roi[0], roi[3], roi[2]};
        Follower one{scene.view}, other{upright};
        std::mt19937_64 random{2};
        for (int i = 0; i < 5; ++i) {
            const test::Shot frame = scene.picture({0.3 * i, 0}).expose({.noise = 2}, random);
            test::Shot turned = frame;
            turned.width = frame.height;
            turned.height = frame.width;
            turned.stride = frame.height;
            for (int y = 0; y < frame.height; ++y) {
                for (int x = 0; x < frame.width; ++x) {
                    *(turned.pixels.data() + std::ptrdiff_t{x} * frame.height + y) =
                        *(frame.view().row(y) + x);
                }
            }
            EXPECT_NEAR(one(frame).x_px, other(turned).y_px, 1e-6) << name << " frame " << i;
        }
    }
}

}  // namespace
}  // namespace shaker::tracking
