// What a picture shows is proposed as a target that the tracker accepts.
#include "tracking/proposals.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker::tracking {
namespace {

class ProposalsTest : public testing::TestWithParam<std::string> {};

/// At any place, in both depths: the target of the scene is among those proposed, and is measured where it
/// is.
TEST_P(ProposalsTest, TheTargetOfAPictureIsProposed) {
    const test::TrackingScene& scene = test::tracking_scene(GetParam());
    std::mt19937_64 random{9};
    std::uniform_real_distribution<double> uniform{-3, 3};
    for (int i = 0; i < 12; ++i) {
        const Point shift{uniform(random), 0};
        const bool deep = i % 2 == 1;
        const test::Shot shot = scene.picture(shift).expose({.bytes_per_pixel = deep ? 2 : 1,
                                                             .noise = 3,
                                                             .depth = deep ? 16.0 : 1,
                                                             .full = deep ? 4095.0 : 255},
                                                            random);
        const Proposals p = proposed_targets(shot.view());
        const TargetKind kind = scene.view.targets.front().kind;
        const auto found = std::ranges::find(p.targets, kind, &Target::kind);
        ASSERT_NE(found, p.targets.end()) << testing::PrintToString(p.refused);
        ViewTracker mine{View{.camera = "view", .mm_per_px = 1, .targets = {*found}}}, described{scene.view};
        const Fix a = mine.update(shot.view(), CameraTick{0}).front(),
                  b = described.update(shot.view(), CameraTick{0}).front();
        const double pitch = found->pitch_mm;
        const double off = pitch > 0 ? std::remainder(a.x_px - b.x_px, pitch / 2) : a.x_px - b.x_px;
        if (kind != TargetKind::code) {  // its place is that of its region
            EXPECT_NEAR(off, 0, 0.1) << found->name;
        }
    }
}
INSTANTIATE_TEST_SUITE_P(Tracking, ProposalsTest,
                         testing::Values("disc", "dot", "rectangle", "dots", "bars", "code"),
                         [](const auto& name) { return name.param; });

// Equal discs at one height are a row only where their distances are equal.
TEST(ProposalsTest, ThreeDiscsAtUnequalDistancesAreNoRow) {
    std::mt19937_64 random{2};
    test::TestPicture picture{500, 80, 60};
    for (const double x : {50.0, 150.0, 420.0}) picture.disc({x, 40}, 15, 170, 0.8);
    const Proposals p = proposed_targets(picture.expose({.noise = 2}, random).view());
    ASSERT_EQ(p.targets.size(), 3U);
    for (const Target& t : p.targets) EXPECT_EQ(t.kind, TargetKind::disc);
}

TEST(ProposalsTest, NothingIsProposedInNoise) {
    std::mt19937_64 random{2};
    const test::Shot shot = test::TestPicture{200, 120, 100}.expose({.noise = 4}, random);
    EXPECT_TRUE(proposed_targets(shot.view()).targets.empty());
}

// A disc that ends at the edge of the picture is no target; a refusal names what was found.
TEST(ProposalsTest, ARefusalNamesWhatWasFound) {
    std::mt19937_64 random{2};
    test::TestPicture picture{200, 120, 60};
    picture.disc({100, 60}, 20, 170, 6);  // far out of focus
    picture.disc({2, 60}, 20, 170, 0.8);
    const Proposals p = proposed_targets(picture.expose({.noise = 2}, random).view());
    for (const Target& t : p.targets) EXPECT_GT(t.roi_px[0], 30) << t.name;
    for (const std::string& why : p.refused) EXPECT_NE(why.find("a disc of "), std::string::npos) << why;
    EXPECT_EQ(p.targets.size() + p.refused.size(), 1U);
}

}  // namespace
}  // namespace shaker::tracking
