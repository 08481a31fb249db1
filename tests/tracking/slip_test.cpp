// Bars and dots look alike after a move by a pitch: a slip in a gap is doubted, found and mended.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/nightly.hpp"
#include "tests/support/tracking/tracking_scene.hpp"
#include "tracking/slip_watch.hpp"

namespace shaker::tracking {
namespace {

constexpr double pitch = 16, period = 50;  // px, pictures

/// A base in a biharmonic motion of `amplitude` px that grows from rest over 100 pictures.
double base_at(int picture, double amplitude) {
    const double phase = 2 * std::numbers::pi * picture / period;
    return amplitude * std::min(1.0, picture / 100.0) *
           (0.8 * std::sin(phase) + 0.2 * std::sin(2 * phase + 1));
}

/// A tracker of a periodic target: it takes the place nearest to the last one.
class Followed {
public:
    Followed(double amplitude, bool oscillates) : amplitude_{amplitude}, watch_{pitch, oscillates} {}

    /// Error of the place in the next picture, px.
    double next() { return look(1); }
    double after_gap(int pictures) { return look(pictures); }
    /// The newest place is reported as degraded.
    [[nodiscard]] bool doubted() const { return doubted_; }

private:
    double look(int pictures) {
        picture_ += pictures;
        const double truth = base_at(picture_, amplitude_);
        place_ = truth + pitch * std::round((place_ - truth) / pitch);
        const double error = place_ - truth;
        const double slip = watch_.take(place_, pictures).value_or(0);
        place_ -= slip;
        doubted_ = watch_.doubt_px() > 0 || slip != 0;
        return error;
    }
    double amplitude_, place_ = 0;
    bool doubted_ = false;
    int picture_ = 0;
    SlipWatch watch_;
};

class SlipWatchTest : public testing::TestWithParam<double> {};

// Wrong by a pitch only while it is doubted, whatever the gap; and right again after at most four periods.
TEST_P(SlipWatchTest, NoSlipIsSilentAndAllAreMended) {
    std::mt19937_64 random{test::seed_of_day(3)};
    std::uniform_int_distribution<int> begins{120, 400}, lasts{2, 400};
    int slipped = 0;
    for (int n = test::plays(500, 20000); n > 0; --n) {
        Followed base{GetParam(), true};
        for (int i = begins(random); i > 0; --i) ASSERT_LT(std::abs(base.next()), 1);
        double error = base.after_gap(lasts(random));
        slipped += std::abs(error) > 1;
        for (int i = 0; i < 4 * period; ++i) {
            if (std::abs(error) > 1) {
                ASSERT_TRUE(base.doubted()) << "picture " << i << ", gap " << n;
            }
            error = base.next();
        }
        EXPECT_LT(std::abs(error), 1);
        EXPECT_FALSE(base.doubted());
    }
    std::printf("amplitude %g px, pitch %g px: %d gaps slipped\n", GetParam(), pitch, slipped);
    EXPECT_EQ(slipped > 0, GetParam() > pitch / 4) << "the case is hard";
}

INSTANTIATE_TEST_SUITE_P(Amplitudes, SlipWatchTest, testing::Values(2, 3, 6, 12, 30));

TEST(SlipWatchRuleTest, ShortGapsOfSmallMotionAreNotDoubted) {
    Followed base{2, true};
    for (int i = 0; i < 300; ++i) base.next();
    base.after_gap(100);
    EXPECT_FALSE(base.doubted());
}

// A place that something else led away in the gap is put back by whole pitches.
TEST(SlipWatchRuleTest, AMoveBeyondWhatIsPossibleIsMended) {
    for (const bool oscillates : {true, false}) {
        SlipWatch watch{pitch, oscillates};
        for (int i = 0; i < 300; ++i) watch.take(base_at(i, 2), 1);
        const double truth = base_at(320, 2);
        for (const int slip : {-2, -1, 1}) {
            EXPECT_EQ(watch.take(truth + slip * pitch, 20), slip * pitch);
            EXPECT_FALSE(watch.take(truth, 1).has_value()) << "the next picture goes on at the right place";
            EXPECT_EQ(watch.doubt_px(), 0);
        }
    }
}

TEST(SlipWatchRuleTest, AWalkerStaysInDoubt) {
    Followed walker{12, false};
    for (int i = 0; i < 300; ++i) walker.next();
    walker.after_gap(25);
    for (int i = 0; i < 1000; ++i) walker.next();
    EXPECT_TRUE(walker.doubted());
}

TEST(SlipWatchRuleTest, ATargetWithoutAPitchIsNeverDoubted) {
    SlipWatch watch{0, true};
    for (const double place : {0.0, 500.0, -500.0}) EXPECT_FALSE(watch.take(place, 1000).has_value());
    EXPECT_EQ(watch.doubt_px(), 0);
}

class SlipTest : public testing::TestWithParam<std::string> {};

// Pictures of a base that moves by more than half a pitch, and is hidden again and again.
TEST_P(SlipTest, NoPictureIsWrongWhileItIsOk) {
    const test::TrackingScene& scene = test::tracking_scene(GetParam());
    View view = scene.view;
    view.targets.front().name = "base";
    const double step = view.targets.front().pitch_mm / view.mm_per_px;
    std::mt19937_64 random{8};
    std::uniform_int_distribution<int> lasts{3, 60};
    test::Follower follow{view};
    double origin = NAN;
    int wrong_ok = 0, wrong = 0, beyond = 0, ok = 0, hidden = 0, pictures = 0;
    for (int i = 0; pictures < 600; ++i, ++pictures) {
        const double shift = 0.7 * step * std::sin(2 * std::numbers::pi * i / 60) * std::min(1.0, i / 60.0);
        test::TestPicture picture = scene.picture({shift, 0});
        if (hidden == 0 && i % 300 == 299) hidden = lasts(random);
        if (hidden > 0) picture.cover({0, 0, picture.width(), picture.height()}, 70), --hidden;
        const Fix fix = follow(picture.expose({.noise = 3}, random));
        if (i == 0) origin = fix.x_px;
        const bool off = std::abs(fix.x_px - shift - origin) > 1;
        wrong += off;
        beyond += std::abs(fix.x_px - shift - origin) > 3 * fix.sd_px + 0.1;
        wrong_ok += off && (fix.state == TrackState::ok || fix.state == TrackState::reacquired);
        ok += fix.state == TrackState::ok;
    }
    std::printf("%s: of %d pictures %d ok, %d off by a pitch, %d of these while ok\n", GetParam().c_str(),
                pictures, ok, wrong, wrong_ok);
    EXPECT_EQ(wrong_ok, 0);
    EXPECT_EQ(beyond, 0) << "the error covers the doubt";
    EXPECT_GT(ok, pictures / 3);
}

INSTANTIATE_TEST_SUITE_P(Tracking, SlipTest, testing::Values("bars", "dots"));

}  // namespace
}  // namespace shaker::tracking
