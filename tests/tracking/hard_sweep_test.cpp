// Each kind of target in hard pictures by the thousand: never off by a pixel while it says ok, and never far
// outside its stated error.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/nightly.hpp"
#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker::tracking {
namespace {

using test::Look, test::Shot, test::TestPicture, test::TrackingScene;

// Pictures at the start and at the end without the difficulty, but for what stays: lens, light, dust.
constexpr int learned = 21, easy_end = 25;

/// Picture `i` of a target at `shift` in a hard case.
struct Conditions {
    TestPicture picture;
    test::Exposure exposure{.noise = 3};
    double flat_field = 0;  // by which the camera evens out its pixels after they are clipped
    bool repeats = false;   // the picture before is delivered again
    bool torn = false;      // the lower half is that of the picture before
};

/// Makes a case from its name. Draws what is in front, changes the light and says the noise.
class Difficulty {
public:
    Difficulty(std::string name, const TrackingScene& scene, int pictures)
        : name_{std::move(name)}, scene_{scene}, easy_from_{pictures - easy_end} {}

    /// The pictures that the camera loses before this one.
    int skipped(int i) {
        return name_ == "dropped" && hard(i) && chance(0.05) ? 1 + static_cast<int>(10 * uniform()) : 0;
    }

    Point wander(int i) {
        if (!hard(i)) return at_;
        if (name_ == "jumps" && chance(0.05)) at_.x = std::clamp(at_.x + 14 * uniform() - 7, -8.0, 8.0);
        if (name_ == "leaves") {
            const int all = easy_from_ - learned, times = std::max(1, all / 200);
            return {0.4 * scene_.width * std::sin(2 * std::numbers::pi * times * (i - learned) / all), 0};
        }
        return at_;
    }

    Conditions picture(int i, Point shift) {
        Look look;
        if (name_ == "sharp") look.blur = 0.3;
        if (name_ == "defocus" && hard(i)) look.blur = 0.8 * (1 + 2 * ramp(i, 200));
        if (name_ == "growing" && hard(i)) look.size = 1 + 0.01 * ramp(i, 150);
        Conditions c{scene_.picture(shift, look)};
        if (name_ == "dust") dust(c.picture);
        TestPicture& p = c.picture;
        if (name_ == "twelve bits")
            c.exposure = {.bytes_per_pixel = 2, .noise = 3, .depth = 16, .full = 3900};
        if (name_ == "faint") p.light(20 / scene_.contrast, 0), c.exposure.noise = 5;
        if (!hard(i)) return c;
        const double w = scene_.width, h = scene_.height, phase = 2 * std::numbers::pi * i / 170;
        if (name_ == "noise") c.exposure.noise = 10;
        if (name_ == "flicker") p.light(0.8 + 0.4 * uniform(), 0);
        if (name_ == "slope") p.light(1, 0.4);
        if (name_ == "exposure") p.light(1 + ramp(i, 120), 0);
        if (name_ == "highlight") p.disc({0.5 * w * (1 + std::sin(phase)), 0.4 * h}, 0.06 * w, 400, 1);
        if (name_ == "card" || name_ == "dark card")
            p.cover({0, 0, static_cast<int>(0.9 * w * std::abs(std::sin(phase))), 9999},
                    name_ == "card" ? 110 : 75);
        if (name_ == "blackout" && i % 60 < 9) p.cover({0, 0, 9999, 9999}, 70);
        c.repeats = name_ == "repeated" && i % 10 == 0;
        c.torn = name_ == "torn" && i % 3 == 0;
        if (name_ == "video range") p.light(2, 0), c.exposure.full = 235;
        if (name_ == "twelve bits") p.light(2, 0);
        if (name_ == "flat field") p.light(2, 0), c.flat_field = 0.03;
        if (name_ == "clutter" && i % 60 < 20) {
            p.cover({0, 0, 9999, 9999}, 90);
            p.texture({0, 0, scene_.width, scene_.height}, {3.3 * i, 0}, 25, 3);
        }
        return c;
    }

    /// As the camera delivers it.
    const Shot& expose(const Conditions& c) {
        if (c.repeats) return shot_;
        Shot shot = c.picture.expose(c.exposure, random_);
        if (c.flat_field > 0) {
            std::mt19937_64 pixels{3};
            std::normal_distribution<double> gain{1, c.flat_field};
            for (std::byte& code : shot.pixels)
                code =
                    std::byte(std::lround(std::min(255.0, 0.8 * gain(pixels) * static_cast<double>(code))));
        }
        if (c.torn)
            std::copy(shot_.pixels.begin() + std::ssize(shot_.pixels) / 2, shot_.pixels.end(),
                      shot.pixels.begin() + std::ssize(shot.pixels) / 2);
        shot_ = std::move(shot);
        return shot_;
    }

    [[nodiscard]] double uniform() { return std::uniform_real_distribution<double>{}(random_); }

private:
    [[nodiscard]] bool hard(int i) const { return i > learned && i < easy_from_; }
    bool chance(double share) { return uniform() < share; }
    static double ramp(int i, int length) {
        return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (i - learned) / length);
    }
    // Specks on the sensor, half of them dark, which stay where they are.
    void dust(TestPicture& p) const {
        std::mt19937_64 places{7};
        std::uniform_real_distribution<double> at{0, 1};
        for (int k = 0; k < scene_.width * scene_.height / 1500; ++k)
            p.disc({at(places) * scene_.width, at(places) * scene_.height}, 0.5 + at(places),
                   k % 2 == 0 ? 90 : 130, 0.8);
    }

    std::string name_;
    Point at_;  // after the jumps
    const TrackingScene& scene_;
    int easy_from_;
    Shot shot_;  // the newest
    std::mt19937_64 random_{test::seed_of_day(12)};
};

struct Outcome {
    int pictures = 0, ok = 0, degraded = 0, lost = 0, wrong = 0, wrong_degraded = 0;
    int repeated = 0, clipped = 0;
    double squares = 0, worst = 0;
    [[nodiscard]] double z() const { return ok > 0 ? std::sqrt(squares / ok) : 0; }
};

class HardSweepTest : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

// Errors are counted from the mean place before the difficulty begins.
TEST_P(HardSweepTest, IsNotWrongWhileItIsOk) {
    const auto& [kind, name] = GetParam();
    const TrackingScene& scene = test::tracking_scene(kind);
    test::Follower follow{scene.view};
    Outcome out;
    double origin = 0, drift = 0;
    const int pictures = test::plays(name == "leaves" ? 240 : 120, 10000);
    Difficulty difficulty{name, scene, pictures};
    TrackState last{};
    for (int i = 0, tick = 0; i < pictures; ++i, ++tick) {
        const int skip = difficulty.skipped(i);
        follow.skip(skip);
        tick += skip;
        drift = std::clamp(drift + 0.2 * (difficulty.uniform() - 0.5), -3.0, 3.0);
        const double swing = 2 * std::sin(2 * std::numbers::pi * tick / 47);
        const Point wander = difficulty.wander(i);
        const Point shift{(i == 0 ? 0 : drift + swing) + wander.x, wander.y};
        const Conditions c = difficulty.picture(i, shift);
        const Fix fix = follow(difficulty.expose(c));
        if (i < learned) {
            ASSERT_TRUE(found(fix.state)) << "picture " << i;
            origin += (fix.x_px - shift.x) / learned;
            continue;
        }
        last = fix.state;
        const double error = fix.x_px - shift.x - origin;
        ++out.pictures;
        out.lost += !found(fix.state);
        out.repeated += fix.state == TrackState::repeated;
        out.clipped += fix.state == TrackState::clipped;
        if (!found(fix.state)) continue;
        const bool wrong = std::abs(error) > 1;
        if (doubtful(fix.state)) {
            ++out.degraded;
            out.wrong_degraded += wrong;
            continue;
        }
        ++out.ok;
        out.wrong += wrong;
        out.squares += error * error / (fix.sd_px * fix.sd_px);
        out.worst = std::max(out.worst, std::abs(error));
    }
    std::printf("| %s | %s | %d | %d | %d | %d | %d | %d | %.2f | %.3f |\n", kind.c_str(), name.c_str(),
                out.pictures, out.ok, out.degraded, out.lost, out.wrong, out.wrong_degraded, out.z(),
                out.worst);
    EXPECT_EQ(out.wrong, 0);
    EXPECT_LE(out.z(), name == "slope" ? 3 : 2);  // uneven light moves an edge by a constant
    EXPECT_TRUE(found(last));
    const int hard = pictures - learned - easy_end;
    const double each = name == "repeated" ? 10 : name == "torn" ? 3 : 0;
    const double old = each > 0 ? hard / each : 0;
    EXPECT_LE(out.repeated, old + 1);
    EXPECT_GE(out.repeated, (name == "torn" ? 0.6 : 1) * old - 1) << "bars hide a part of the noise";
    constexpr std::array too_bright{"video range", "flat field", "twelve bits",
                                    "exposure",    "highlight",  "slope"};
    if (std::ranges::find(too_bright, name) == too_bright.end()) {
        EXPECT_EQ(out.clipped, 0);
    } else if (each == 0 && name != "exposure" && name != "highlight" && name != "slope") {
        EXPECT_LE(out.ok, pictures - learned - 0.9 * hard) << "places that are clipped are ok";
    }
}

INSTANTIATE_TEST_SUITE_P(Tracking, HardSweepTest,
                         testing::Combine(testing::Values("disc", "dot", "arcs", "twin", "rectangle", "dots",
                                                          "bars", "patch", "code"),
                                          testing::Values("noise", "faint", "flicker", "slope", "exposure",
                                                          "highlight", "card", "dark card", "blackout",
                                                          "clutter", "dust", "sharp", "defocus", "growing",
                                                          "dropped", "jumps", "leaves", "repeated", "torn",
                                                          "video range", "flat field", "twelve bits")),
                         [](const auto& p) {
                             std::string name = std::get<0>(p.param) + "_" + std::get<1>(p.param);
                             std::ranges::replace(name, ' ', '_');
                             return name;
                         });

}  // namespace
}  // namespace shaker::tracking
