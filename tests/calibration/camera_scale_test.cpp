#include "calibration/camera/camera_scale.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace shaker::calibration {
namespace {

View plain() {
    View view;
    view.mm_per_px = 0.4;
    view.distance_mm = 600;
    view.along = {0.6, 0.8};
    return view;
}

TEST(CameraScaleTest, IsUnchangedToTheBitWithoutALens) {
    const View view = plain();
    EXPECT_EQ(metres_along(view, 12, 100.3, -20.7),
              1e-3 * (0.4 * (1 - 12.0 / 600)) * (0.6 * 100.3 + 0.8 * -20.7));
    EXPECT_EQ(mm_per_px_at(view, 12, 100.3, -20.7), mm_per_px_at(view, 12));
}

TEST(CameraScaleTest, ALensWithoutDistortionChangesOnlyTheZero) {
    View view = plain();
    const double before = metres_along(view, 12, 300, 40) - metres_along(view, 12, 20, 7);
    view.lens = {.centre_px = {160, 48}, .focal_px = 1500};
    EXPECT_NEAR(metres_along(view, 12, 300, 40) - metres_along(view, 12, 20, 7), before, 1e-15);
    EXPECT_NEAR(mm_per_px_at(view, 12, 200, 30), mm_per_px_at(view, 12), 1e-12);
}

TEST(CameraScaleTest, UndistortsWhatTheLensDistorts) {
    const Lens lens{{160, 48}, 900, -0.3, 0.12, 2e-3, -1e-3};
    for (const double x : {-0.3, -0.05, 0.0, 0.2})
        for (const double y : {-0.2, 0.01, 0.25}) {
            const auto [u, v] = lens.distorted(x, y);
            const auto [at_x, at_y] = optics::undistorted(lens, {160 + 900 * u, 48 + 900 * v});
            EXPECT_NEAR(at_x, x, 1e-12);
            EXPECT_NEAR(at_y, y, 1e-12);
        }
}

TEST(CameraScaleTest, IsNotANumberWhereTheLensMapsNothing) {
    const Lens folding{{0, 0}, 100, -0.3, 0, 0, 0};  // its largest radius in the picture is 70.3 px
    EXPECT_TRUE(std::isfinite(optics::undistorted(folding, {69, 0})[0]));
    EXPECT_TRUE(std::isnan(optics::undistorted(folding, {72, 0})[0]));
}

// A point at s on the axis of a plane tilted by theta about y is at X = s cos, Z = Z_0 + s sin.
TEST(CameraScaleTest, IntersectsTheTiltedPlane) {
    View view = plain();
    view.along = {1, 0};
    view.lens = {.centre_px = {160, 48}, .focal_px = 1500};
    view.tilt_deg = {3, 0};
    const double theta = 3 * std::numbers::pi / 180, height = 12;
    const auto place = [&](double s_mm) {
        const double x = s_mm * std::cos(theta) + height * std::sin(theta);
        const double z = 600 + s_mm * std::sin(theta) - height * std::cos(theta);
        return metres_along(view, height, 160 + 1500 * x / z, 48);
    };
    for (const double s : {-60.0, -5.0, 20.0, 75.0}) EXPECT_NEAR(place(s) - place(0), 1e-3 * s, 1e-14);
    EXPECT_NEAR(mm_per_px_at(view, 0, 160, 48), 0.4 / std::cos(theta), 1e-6);
}

TEST(CameraScaleTest, CountsFromTheSensorsCornerWhenThePictureIsCropped) {
    View whole = plain();
    whole.lens = {.centre_px = {160, 48}, .focal_px = 1500, .k1 = -0.2};
    View part = whole;
    part.origin_px = {20, 30};
    EXPECT_EQ(metres_along(part, 12, 100.5, 3.25), metres_along(whole, 12, 120.5, 33.25));
}

TEST(CameraScaleTest, LocalScaleIsTheDerivativeAlongTheAxis) {
    View view = plain();
    view.lens = {.centre_px = {160, 48}, .focal_px = 500, .k1 = -0.4, .k2 = 0.1};
    view.tilt_deg = {2, -3};
    const double far = mm_per_px_at(view, 12, 300, 90);
    EXPECT_GT(std::abs(far / mm_per_px_at(view, 12) - 1), 0.05);
    const double moved =
        metres_along(view, 12, 300 + 0.06, 90 + 0.08) - metres_along(view, 12, 300 - 0.06, 90 - 0.08);
    EXPECT_NEAR(far, 1e3 * moved / 0.2, 1e-5 * far);
}

}  // namespace
}  // namespace shaker::calibration
