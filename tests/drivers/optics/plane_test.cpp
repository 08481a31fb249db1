#include "drivers/optics/plane.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>

namespace shaker::optics {
namespace {

View tilted() {
    View view;
    view.mm_per_px = 0.4;
    view.distance_mm = 600;
    view.along = {0.8, -0.6};
    view.tilt_deg = {3, -2};
    view.lens = {{170, 40}, 900, -0.3, 0.12, 2e-3, -1e-3};
    return view;
}

TEST(PlaneTest, ImageAndPlaceAreInverse) {
    View with_lens = tilted(), telecentric = tilted(), plain = tilted();
    telecentric.distance_mm = 0;
    plain.lens = {};
    plain.tilt_deg = {};
    for (const View& view : {with_lens, telecentric, plain})
        for (const double offset : {0.0, 12.0})
            for (const Point& place : {Point{-40, 10}, Point{3, -20}, Point{55, 31}}) {
                const Point back = place_at(view, offset, image_of(view, offset, place));
                EXPECT_NEAR(back[0], place[0], 1e-9);
                EXPECT_NEAR(back[1], place[1], 1e-9);
            }
}

// The plane's axes as a rotation; the focal length of the pinhole is distance / scale.
TEST(PlaneTest, AgreesWithOpenCvsProjection) {
    View view = tilted();
    view.lens.focal_px = view.distance_mm / view.mm_per_px;
    const double a = std::tan(3 * std::numbers::pi / 180), b = std::tan(-2 * std::numbers::pi / 180);
    const cv::Vec3d normal = cv::normalize(cv::Vec3d{-a, -b, 1});
    const cv::Vec3d along = cv::normalize(cv::Vec3d{0.8, -0.6, 0.8 * a - 0.6 * b}),
                    across = normal.cross(along);
    const cv::Mat camera =
        (cv::Mat_<double>(3, 3) << view.lens.focal_px, 0, 170, 0, view.lens.focal_px, 40, 0, 0, 1);
    const std::vector<double> lens{-0.3, 0.12, 2e-3, -1e-3};
    for (const Point& place : {Point{-40, 10}, Point{3, -20}, Point{55, 31}}) {
        const cv::Vec3d at = place[0] * along + place[1] * across - 12 * normal + cv::Vec3d{0, 0, 600};
        std::vector<cv::Point2d> seen;
        cv::projectPoints(std::vector<cv::Point3d>{{at[0], at[1], at[2]}}, cv::Vec3d{}, cv::Vec3d{}, camera,
                          lens, seen);
        const Point image = image_of(view, 12, place);
        EXPECT_NEAR(image[0], seen[0].x, 1e-9);
        EXPECT_NEAR(image[1], seen[0].y, 1e-9);
    }
}

}  // namespace
}  // namespace shaker::optics
