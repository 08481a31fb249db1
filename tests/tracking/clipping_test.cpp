// Pictures that are exposed too long.
#include "tracking/clipping.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker::tracking {
namespace {

using test::Follower, test::TestPicture, test::TrackingScene;

struct Depth {
    std::string name;
    int bytes;
    double depth, full;
};

class ClippingTest : public testing::TestWithParam<std::string> {
protected:
    const TrackingScene& scene_ = test::tracking_scene(GetParam());
    std::mt19937_64 random_{5};
    [[nodiscard]] test::Shot shot(double shift, double gain, const Depth& depth) {
        TestPicture picture = scene_.picture({shift, 0});
        picture.light(gain, 0);
        return picture.expose(
            {.bytes_per_pixel = depth.bytes, .noise = 3, .depth = depth.depth, .full = depth.full}, random_);
    }
};

// An exposure that becomes twice and three times too long: every place is called degraded, and its error
// covers.
TEST_P(ClippingTest, AClippedTargetIsDegradedWithAnErrorThatCovers) {
    for (const Depth& depth :
         {Depth{"8 bit", 1, 1, 255}, Depth{"10 bit", 2, 4, 1023}, Depth{"12 bit", 2, 16, 4095}}) {
        for (const double gain : {2.0, 3.0}) {
            Follower follow{scene_.view};
            double origin = 0;
            for (int i = 0; i < 16; ++i) {
                const Fix fix = follow(shot(0, 1, depth));
                EXPECT_TRUE(i == 0 || fix.state == TrackState::ok) << depth.name;
                origin += fix.x_px / 16;
            }
            for (int i = 0; i < 40; ++i) {
                const double shift = 1.5 * std::sin(0.4 * i);
                const Fix fix = follow(shot(shift, gain, depth));
                EXPECT_NE(fix.state, TrackState::ok) << depth.name << " gain " << gain << " picture " << i;
                if (found(fix.state)) {
                    EXPECT_LT(std::abs(fix.x_px - shift - origin), 3 * fix.sd_px)
                        << depth.name << " gain " << gain << " picture " << i;
                }
            }
        }
    }
}
INSTANTIATE_TEST_SUITE_P(Tracking, ClippingTest,
                         testing::Values("disc", "dot", "arcs", "rectangle", "dots", "bars", "patch", "code"),
                         [](const auto& name) { return name.param; });

TEST(ClippedShareTest, CountsTheLastCodeOfEveryDepth) {
    for (const unsigned full : {1023U, 4095U, 65535U, 0xFFF0U}) {
        std::vector<std::uint16_t> codes(400, 700);
        const ImageView image{reinterpret_cast<const std::byte*>(codes.data()), 20, 20, 40, 2};
        EXPECT_EQ(clipped_share(image, {0, 0, 20, 20}), 0) << full;
        for (std::size_t i = 0; i < 100; ++i) codes[i] = static_cast<std::uint16_t>(full);
        EXPECT_EQ(clipped_share(image, {0, 0, 20, 20}), 0.25) << full;
        EXPECT_EQ(clipped_share(image, {-5, -5, 5, 5}), 1) << full;
        EXPECT_EQ(clipped_share(image, {30, 0, 40, 20}), 0) << full;
    }
}

}  // namespace
}  // namespace shaker::tracking
