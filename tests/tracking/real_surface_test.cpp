// Surfaces and cameras that no model draws: marks of a lathe, bevels, columns of pixels with noise of their
// own.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "tests/support/rms.hpp"
#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker::tracking {
namespace {

using test::Follower, test::Look, test::rms_about_mean, test::Shot, test::TestPicture, test::TrackingScene;

// A disc with rings of 2 grey levels, or with a bevel 4 px wide, 25 grey levels darker than its face.
TrackingScene disc(double radius, bool marks, bool bevel) {
    TrackingScene scene = test::tracking_scene("disc");
    const int side = 2 * static_cast<int>(radius) + 40;
    scene.width = side + 40, scene.height = side;
    Target& target = scene.view.targets.front();
    target.diameter_mm = 0.5 * radius;
    target.roi_px = {28, 8, side - 16, side - 16};
    const Point middle{0.5 * scene.width + 0.3, 0.5 * side - 0.2};
    scene.draw = [=](TestPicture& p, Point shift, const Look& look) {
        p.disc(middle + shift, radius, bevel ? 135 : 160, look.blur);
        if (bevel) p.disc(middle + shift, radius - 4, 160, look.blur);
        if (marks) p.turned(middle + shift, radius, 2, 5);
    };
    const double at_50 = scene.bound(3);
    scene.bound = [=](double noise) { return at_50 * std::sqrt(50 / radius) * noise / 3; };
    return scene;
}

TrackingScene bevelled_rectangle() {
    TrackingScene scene = test::tracking_scene("rectangle");
    scene.draw = [](TestPicture& p, Point s, const Look& look) {
        p.rectangle(88.3 + s.x, 25 + s.y, 168.3 + s.x, 90, 135, look.blur);
        p.rectangle(92.3 + s.x, 25 + s.y, 164.3 + s.x, 90, 160, look.blur);
    };
    return scene;
}

// The error that depends on the place within a pixel only, px rms, of 12 bit counts without noise.
double locking(const TrackingScene& scene) {
    std::mt19937_64 random{7};
    Follower follow{scene.view};
    std::vector<double> errors;
    constexpr int learned = 48;  // pictures
    for (int i = 0; i < learned + 64; ++i) {
        const double shift = i / 32.0;
        const Fix fix = follow(
            scene.picture({shift, 0}).expose({.bytes_per_pixel = 2, .depth = 16, .full = 4095}, random));
        EXPECT_TRUE(found(fix.state)) << scene.name << " at a shift of " << shift;
        if (i >= learned) errors.push_back(fix.x_px - shift);
    }
    return rms_about_mean(errors);
}

TEST(RealSurfaceTest, MarksOfALatheDoNotLock) {
    for (const double radius : {50.0, 100.0, 120.0}) {
        const double px = locking(disc(radius, true, false));
        std::printf("disc of %.0f px, marks of 2 grey levels: locking %.5f px rms\n", radius, px);
        EXPECT_LT(px, 0.0007);
    }
}

TEST(RealSurfaceTest, BevelsDoNotLock) {
    const double round = locking(disc(50, false, true)), straight = locking(bevelled_rectangle());
    std::printf("bevel of 25 grey levels: disc %.5f, rectangle %.5f px rms\n", round, straight);
    EXPECT_LT(round, 0.001);
    EXPECT_LT(straight, 0.001);
}

// Noise of 3, 300 pictures: an rms is known to 4 %.
TEST(RealSurfaceTest, MarksHardlyCostAccuracy) {
    for (const double radius : {50.0, 100.0}) {
        const TrackingScene scene = disc(radius, true, false);
        std::mt19937_64 random{11};
        std::uniform_real_distribution<double> step{-0.4, 0.4};
        Follower follow{scene.view};
        std::vector<double> errors;
        double shift = 0, variance = 0;
        for (int i = 0; i < 300; ++i) {
            const Fix fix = follow(scene.picture({shift, 0}).expose({.noise = 3}, random));
            ASSERT_TRUE(found(fix.state)) << i;
            errors.push_back(fix.x_px - shift);
            variance += fix.sd_px * fix.sd_px / 300;
            shift += step(random);
        }
        const double ratio = rms_about_mean(errors) / scene.bound(3);
        std::printf("disc of %.0f px, marks: %.2f times Cramer and Rao, %.2f times the stated\n", radius,
                    ratio, rms_about_mean(errors) / std::sqrt(variance));
        EXPECT_LT(ratio, 1.25 * 1.08);
    }
}

/// What a camera makes of a picture, besides noise.
struct Camera {
    std::string name;
    std::function<void(cv::Mat&, std::mt19937_64& noise)> spoil;  // 8 bit, in place
    bool other_edge = false;
};

std::vector<Camera> cameras() {
    const auto columns_of = [](std::uint64_t seed, double sd, int width) {
        std::mt19937_64 random{seed};
        std::normal_distribution<double> normal{0, sd};
        cv::Mat1d one(1, width);
        for (int x = 0; x < width; ++x) one(0, x) = normal(random);
        return one;
    };
    const auto each = [](cv::Mat& picture, auto change) {
        for (int y = 0; y < picture.rows; ++y)
            for (int x = 0; x < picture.cols; ++x)
                picture.at<std::uint8_t>(y, x) =
                    cv::saturate_cast<std::uint8_t>(change(picture.at<std::uint8_t>(y, x), x, y));
    };
    return {
        {"no other", [](cv::Mat&, std::mt19937_64&) {}},
        {"gain of pixels 2 %, columns 2",
         [=](cv::Mat& p, std::mt19937_64&) {
             const cv::Mat1d offsets = columns_of(3, 2, p.cols);
             std::mt19937_64 pixels{4};
             std::normal_distribution<double> gain{1, 0.02};
             each(p, [&](double v, int x, int) { return v * gain(pixels) + offsets(0, x); });
         }},
        {"noise of columns 1.5",
         [=](cv::Mat& p, std::mt19937_64& random) {
             const cv::Mat1d offsets = columns_of(random(), 1.5, p.cols);
             each(p, [&](double v, int x, int) { return v + offsets(0, x); });
         }},
        {"JPEG 40",
         [](cv::Mat& p, std::mt19937_64&) {
             std::vector<std::uint8_t> file;
             cv::imencode(".jpg", p, file, {cv::IMWRITE_JPEG_QUALITY, 40});
             cv::imdecode(file, cv::IMREAD_GRAYSCALE).copyTo(p);
         },
         true},
        {"unsharp mask",
         [](cv::Mat& p, std::mt19937_64&) {
             cv::Mat blurred;
             cv::GaussianBlur(p, blurred, {}, 1.5);
             cv::addWeighted(p, 1.8, blurred, -0.8, 0, p);
         },
         true},
        {"dust",
         [=](cv::Mat& p, std::mt19937_64&) {
             std::mt19937_64 places{7};
             std::uniform_real_distribution<double> at{0, 1};
             cv::Mat1f share(p.size(), 1);
             for (int k = 0; k < 16; ++k) {
                 const double cx = at(places) * p.cols, cy = at(places) * p.rows, r = 1 + 2 * at(places);
                 for (int y = 0; y < p.rows; ++y)
                     for (int x = 0; x < p.cols; ++x)
                         share(y, x) *= static_cast<float>(
                             1 - 0.25 * std::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (2 * r * r)));
             }
             each(p, [&](double v, int x, int y) { return v * static_cast<double>(share(y, x)); });
         },
         true}};
}

// A clamp beside an eighth of an edge: that group drops out, and what the groups have in common is not
// learned from it.
TEST(RealSurfaceTest, AClampBesideAnEdgeDoesNotEnlargeTheStatedError) {
    const TrackingScene& scene = test::tracking_scene("rectangle");
    double with = 0, without = 0;
    for (const bool clamp : {false, true}) {
        std::mt19937_64 random{11};
        Follower follow{scene.view};
        for (int i = 0; i < 120; ++i) {
            const double shift = 3 * std::sin(0.37 * i);
            TestPicture picture = scene.picture({shift, 0});
            if (clamp && i > 40) picture.cover({84, 45, 87, 50}, 110);
            const Fix fix = follow(picture.expose({.noise = 3}, random));
            ASSERT_TRUE(found(fix.state)) << i;
            if (i > 60) (clamp ? with : without) += fix.sd_px / 59;
        }
    }
    std::printf("rectangle: stated %.4f px, with a clamp %.4f px\n", without, with);
    EXPECT_LT(with, 1.4 * without);
}

// Errors of a rectangle are known to 4 % from 300 pictures of noise.
TEST(RealSurfaceTest, ARectangleStatesItsErrorBehindAnyCamera) {
    const TrackingScene& scene = test::tracking_scene("rectangle");
    for (const Camera& camera : cameras()) {
        std::mt19937_64 random{11};
        Follower follow{scene.view};
        std::vector<double> errors;
        double variance = 0;
        for (int i = 0; i < 300; ++i) {
            const double shift = 6 * std::sin(0.37 * i) + 3 * std::sin(0.11 * i);
            Shot shot = scene.picture({shift, 0}).expose({.noise = 2}, random);
            cv::Mat picture{shot.height, shot.width, CV_8U, shot.pixels.data(),
                            static_cast<std::size_t>(shot.stride)};
            camera.spoil(picture, random);
            const Fix fix = follow(shot);
            ASSERT_TRUE(found(fix.state)) << camera.name << ", picture " << i;
            if (i < 40) continue;  // what the columns have in common is learned from pictures
            errors.push_back(fix.x_px - shift);
            variance += fix.sd_px * fix.sd_px / 260;
        }
        const double ratio = rms_about_mean(errors) / std::sqrt(variance);
        std::printf("rectangle, %s: %.4f px rms, %.2f times the stated\n", camera.name.c_str(),
                    rms_about_mean(errors), ratio);
        EXPECT_LT(ratio, 1.3) << camera.name;
        // An edge of another shape than the model's counts as noise, although it moves with the target: the
        // error is stated too large behind a sharpened, compressed or dusty picture.
        EXPECT_GT(ratio, camera.other_edge ? 0.3 : 0.75) << camera.name;
    }
}

}  // namespace
}  // namespace shaker::tracking
