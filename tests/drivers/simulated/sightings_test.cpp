// A camera that gives positions reports the truth with its stated noise.
#include <gtest/gtest.h>

#include "drivers/simulated/true_view.hpp"

namespace shaker::simulated {
namespace {

CameraTruth top() {
    CameraTruth camera = paper_scene().cameras[0];
    camera.view.positions = true;
    return camera;
}

TEST(SightingsTest, ScatterAroundTruthByStatedError) {
    const CameraTruth camera = top();
    const PictureLayout layout = layout_of(camera, WalkerTruth{});
    const std::array<Pose, 3> poses{{{1e-3, -20e-3}, {2e-3, -21e-3}, {3e-3, -22e-3}}};
    const double walker = layout.centre_x - 21e-3 * layout.walker_px_per_m;
    const double base = layout.centre_x + 2e-3 * layout.base_px_per_m;
    double sum = 0, square = 0, product = 0;
    constexpr int count = 4000;
    for (int n = 0; n < count; ++n) {
        const auto seen = sightings(camera, layout, poses, {n}, true, 5);
        const double u = (seen.at(0).x_px - walker) / seen[0].sd_px,
                     v = (seen.at(1).x_px - base) / seen[1].sd_px;
        sum += u + v;
        square += u * u + v * v;
        product += u * v;
    }
    EXPECT_NEAR(sum / (2 * count), 0, 0.06);
    EXPECT_NEAR(square / (2 * count), 1, 0.06);
    EXPECT_NEAR(product / count, 0, 0.06);
}

TEST(SightingsTest, DependOnSeedAndTickOnly) {
    const CameraTruth camera = top();
    const PictureLayout layout = layout_of(camera, WalkerTruth{});
    const std::array<Pose, 1> pose{};
    const auto at = [&](std::int64_t n, std::uint64_t seed) {
        return sightings(camera, layout, pose, {n}, true, seed).at(0).x_px;
    };
    EXPECT_EQ(at(3, 1), at(3, 1));
    EXPECT_NE(at(3, 1), at(4, 1));
    EXPECT_NE(at(3, 1), at(3, 2));
}

TEST(SightingsTest, WalkerOutsideThePictureIsNotSeen) {
    const CameraTruth camera = top();
    const PictureLayout layout = layout_of(camera, WalkerTruth{});
    for (const double away_m : {-0.2, 0.2}) {
        const std::array<Pose, 1> pose{{{0, away_m}}};
        const auto seen = sightings(camera, layout, pose, {0}, true, 1);
        EXPECT_TRUE(std::isnan(seen.at(0).x_px)) << away_m;
        EXPECT_FALSE(std::isnan(seen.at(1).x_px)) << "the base";
    }
    EXPECT_TRUE(std::isnan(sightings(camera, layout, std::array<Pose, 1>{}, {0}, false, 1).at(0).x_px));
}

}  // namespace
}  // namespace shaker::simulated
