// Bars of irregular width: at the noise limit, and found again at their place after any gap.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "drivers/errors.hpp"
#include "drivers/simulated/renderer.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker::tracking {
namespace {

class CodeTest : public testing::TestWithParam<std::string> {
protected:
    const test::TrackingScene& scene_ = test::tracking_scene(GetParam());
    std::mt19937_64 random_{7};
};

double scatter_of(const std::vector<double>& v) {
    double mean = 0, sum = 0;
    for (const double x : v) mean += x / static_cast<double>(v.size());
    for (const double x : v) sum += (x - mean) * (x - mean);
    return std::sqrt(sum / static_cast<double>(v.size()));
}

TEST_P(CodeTest, LocksByLessThanATenThousandthOfAPixel) {
    test::Follower follow{scene_.view};
    std::vector<double> errors;
    for (int i = 0; i < 64; ++i) {
        const auto shot =
            scene_.picture({i / 32.0, 0}).expose({.bytes_per_pixel = 2, .depth = 16, .full = 4095}, random_);
        errors.push_back(follow(shot).x_px - i / 32.0);
    }
    EXPECT_LT(scatter_of(errors), 1e-4);
}

// The lens goes out of focus while the strip is followed, up to where the picture counts as degraded.
TEST_P(CodeTest, StatesItsErrorOutOfFocus) {
    for (const double blur : {0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.6, 1.8}) {
        test::Follower follow{scene_.view};
        constexpr int sharp = 24, blurred = 64;
        double origin = 0, squares = 0, ok = 0;
        for (int i = 0; i < sharp + blurred; ++i) {
            const double shift = 2 * std::sin(0.4 * i);
            const test::Look look{.blur = i < sharp ? 0.8 : blur};
            const Fix fix = follow(scene_.picture({shift, 0}, look).expose({.noise = 3}, random_));
            const double off = fix.x_px - shift - origin;
            if (i < sharp) origin += off / (i + 1);
            if (i < sharp || fix.state != TrackState::ok) continue;
            ok += 1;
            squares += off * off / (fix.sd_px * fix.sd_px);
        }
        EXPECT_LE(squares, 4 * ok) << "blur " << blur << " px, " << ok << " pictures ok";
        std::printf("%s, blur %.1f px: %g pictures ok, rms %.2f stated errors\n", scene_.name.c_str(), blur,
                    ok, std::sqrt(squares / std::max(ok, 1.0)));
    }
}

TEST_P(CodeTest, ErrorIsNearTheCramerRaoBound) {
    test::Follower follow{scene_.view};
    std::uniform_real_distribution<double> step{-0.4, 0.4};
    std::vector<double> errors;
    double shift = 0;
    for (int i = 0; i < 200; ++i, shift += step(random_))
        errors.push_back(follow(scene_.picture({shift, 0}).expose({.noise = 3}, random_)).x_px - shift);
    EXPECT_LT(scatter_of(errors), 1.2 * scene_.bound(3));
}

// A base that swings by 11 px is hidden for ten pictures, or five pictures are dropped, again and again; a
// third of the strip is hidden in some swings.
TEST_P(CodeTest, IsAtItsPlaceAfterEveryGap) {
    test::Follower follow{scene_.view};
    std::uniform_int_distribution<int> wait{15, 60};
    double origin = NAN;
    int gap_at = 40, gaps = 0, hidden_until = 0, lost = 0;
    for (int i = 0; gaps < test::plays(6, 400); ++i) {
        const double shift = 11 * std::sin(2 * std::numbers::pi * i / 50) * std::min(1.0, i / 20.0);
        if (i == gap_at) {
            const bool dark = ++gaps % 2 == 0;
            hidden_until = dark ? i + 10 : 0;
            gap_at = i + wait(random_);
            if (!dark) {
                follow.skip(5);
                i += 4;
                continue;
            }
        }
        test::TestPicture picture = scene_.picture({shift, 0});
        const bool dark = i < hidden_until;
        if (dark) picture.cover({0, 0, scene_.width, scene_.height}, 70);
        if (gaps % 3 == 2) picture.cover({0, 0, scene_.width / 3, scene_.height}, 110);
        const Fix fix = follow(picture.expose({.noise = 3}, random_));
        if (i == 0) origin = fix.x_px;
        EXPECT_EQ(found(fix.state), !dark) << "picture " << i;
        lost += !found(fix.state);
        if (found(fix.state)) {
            EXPECT_LT(std::abs(fix.x_px - shift - origin), 0.1) << "picture " << i;
        }
    }
    EXPECT_GT(lost, 0);
}

INSTANTIATE_TEST_SUITE_P(Tracking, CodeTest, testing::Values("code", "wide code"), [](const auto& p) {
    return p.param == "code" ? std::string{"Narrow"} : std::string{"Wide"};
});

TEST(RegularBarsTest, AreRefusedAsACode) {
    const test::TrackingScene& scene = test::tracking_scene("bars");
    View view = scene.view;
    view.targets.front().kind = TargetKind::code;
    std::mt19937_64 random{2};
    const test::Shot shot = scene.picture({0, 0}).expose({.noise = 2}, random);
    try {
        test::Follower{view}(shot);
        FAIL() << "accepted";
    } catch (const InputError& e) {
        EXPECT_NE(std::string{e.what()}.find("kind = \"bars\""), std::string::npos) << e.what();
    }
}

// Both cameras of a simulated bench whose base carries a strip, one of them turned by 180 degrees.
TEST(SimulatedCodeTest, IsFollowedInBothViews) {
    const simulated::Scene scene =
        simulated::parse_scene("[top]\ncode_seed = 4\n[side]\ncode_seed = 4\nalong_x = -1\n", "code.toml");
    EXPECT_EQ(simulated::scene_text(simulated::parse_scene(simulated::scene_text(scene), "again")),
              simulated::scene_text(scene));
    for (const simulated::CameraTruth& camera : scene.cameras) {
        View view = camera.view;
        view.targets.erase(view.targets.begin());
        ASSERT_EQ(view.targets.front().kind, TargetKind::code);
        simulated::Renderer renderer{camera, scene.walker, 5};
        const double px_per_m = simulated::layout_of(camera, scene.walker).base_px_per_m * view.along[0];
        std::vector<std::byte> pixels(static_cast<std::size_t>(camera.width * camera.height));
        ViewTracker tracker{view};
        double origin = 0;
        for (int i = 0; i < 40; ++i) {
            const simulated::Pose pose{0.002 * std::sin(0.9 * i), 0};
            renderer.render({&pose, 1}, CameraTick{i}, pixels);
            const ImageView image{pixels.data(), camera.width, camera.height, camera.width, 1};
            const Fix fix = tracker.update(image, CameraTick{i}).front();
            ASSERT_EQ(fix.state, TrackState::ok) << view.camera << " picture " << i;
            if (i == 0) origin = fix.x_px;
            EXPECT_NEAR(fix.x_px - origin, px_per_m * pose.base, 6 * fix.sd_px) << view.camera << i;
        }
    }
}

}  // namespace
}  // namespace shaker::tracking
