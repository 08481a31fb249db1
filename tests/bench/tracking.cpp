// Tracking: cost and error of each kind against its bound, beside cv::matchTemplate and cv::phaseCorrelate on
// the same frames; with --losses the cost of pictures in which a target is learned, lost and found again,
// with
// --pair that of walker and base in both views of the nominal scene
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "tests/bench/table.hpp"
#include "tests/support/cost.hpp"
#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker {
namespace {

constexpr int frames = 100;
constexpr double noise = 3;

struct Result {
    std::vector<double> error_px, cost_us;
    double sd_px = std::numeric_limits<double>::quiet_NaN();
    int lost = 0;
};

struct Movie {
    std::vector<test::Shot> shots;
    std::vector<double> shift;
};

Movie movie_of(const test::TrackingScene& scene) {
    Movie movie;
    std::mt19937_64 random{17};
    std::uniform_real_distribution<double> step{-0.4, 0.4};
    double shift = 0;
    for (int i = 0; i < frames; ++i) {
        movie.shift.push_back(shift);
        movie.shots.push_back(scene.picture({shift, 0}).expose({.noise = noise}, random));
        shift += step(random);
    }
    return movie;
}

/// Frame 0 is set-up and not counted. `locate` returns x in px, NaN if the target was not found.
template <class Locate>
Result measure(const Movie& movie, Locate locate) {
    Result result;
    for (std::size_t i = 0; i < movie.shots.size(); ++i) {
        const double before = bench::cpu_ns();
        const double x = locate(movie.shots[i]);
        const double after = bench::cpu_ns();
        if (i == 0) continue;
        result.cost_us.push_back(1e-3 * (after - before));
        if (std::isfinite(x)) {
            result.error_px.push_back(x - movie.shift[i]);
        } else {
            ++result.lost;
        }
    }
    return result;
}

double rms_about_mean(const std::vector<double>& v) {
    double mean = 0, sum = 0;
    for (const double x : v) mean += x / static_cast<double>(v.size());
    for (const double x : v) sum += (x - mean) * (x - mean);
    return std::sqrt(sum / static_cast<double>(v.size()));
}

double median(std::vector<double> v) {
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return *middle;
}

cv::Mat grey(const test::Shot& shot) {
    return {shot.height, shot.width, CV_8UC1, const_cast<std::byte*>(shot.pixels.data()),
            static_cast<std::size_t>(shot.stride)};
}

cv::Rect region(const test::TrackingScene& scene) {
    const auto& r = scene.view.targets.front().roi_px;
    return {r[0], r[1], r[2], r[3]};
}

Result by_tracker(const test::TrackingScene& scene, const Movie& movie) {
    test::Follower follow{scene.view};
    std::vector<double> sds;
    Result result = measure(movie, [&](const test::Shot& shot) {
        const tracking::Fix fix = follow(shot);
        if (found(fix.state)) sds.push_back(fix.sd_px);
        return fix.x_px;
    });
    result.sd_px = median(sds);
    return result;
}

// The region of frame 0, searched within 12 px of its last position; peak by a parabola.
Result by_match_template(const test::TrackingScene& scene, const Movie& movie) {
    constexpr int reach = 12;
    const cv::Rect start = region(scene);
    cv::Mat pattern, score;
    int x = start.x;
    return measure(movie, [&](const test::Shot& shot) {
        const cv::Mat picture = grey(shot);
        if (pattern.empty()) pattern = picture(start).clone();
        const int x0 = std::max(0, x - reach), x1 = std::min(shot.width, x + start.width + reach);
        cv::matchTemplate(picture(cv::Rect{x0, start.y, x1 - x0, start.height}), pattern, score,
                          cv::TM_CCOEFF_NORMED);
        cv::Point best;
        cv::minMaxLoc(score, nullptr, nullptr, nullptr, &best);
        x = x0 + best.x;
        if (best.x < 1 || best.x + 1 >= score.cols) return std::numeric_limits<double>::quiet_NaN();
        const float* s = score.ptr<float>(0) + best.x;
        const double left = s[-1], here = s[0], right = s[1];
        return x - start.x + 0.5 * (left - right) / (left - 2 * here + right);
    });
}

Result by_phase_correlation(const test::TrackingScene& scene, const Movie& movie) {
    const cv::Rect start = region(scene);
    cv::Mat pattern, window, now;
    return measure(movie, [&](const test::Shot& shot) {
        grey(shot)(start).convertTo(now, CV_64F);
        if (pattern.empty()) {
            pattern = now.clone();
            cv::createHanningWindow(window, start.size(), CV_64F);
        }
        return cv::phaseCorrelate(pattern, now, window).x;
    });
}

bench::Row row(const test::TrackingScene& scene, const std::string& method, const Result& result) {
    return {
        {"kind", scene.name},
        {"method", method},
        {"cost", median(result.cost_us), "us/frame"},
        {"rms error",
         result.error_px.empty() ? std::numeric_limits<double>::quiet_NaN() : rms_about_mean(result.error_px),
         "px"},
        {"sd claimed", result.sd_px, "px"},
        {"Cramer-Rao bound", scene.bound(noise), "px"},
        {"lost", static_cast<double>(result.lost)},
        {"conditions", std::to_string(scene.width) + "x" + std::to_string(scene.height) + ", contrast " +
                           std::to_string(static_cast<int>(scene.contrast)) + ", noise 3, PSF 0.8 px"}};
}

/// Costs of one part of a movie, us.
struct Costs {
    std::vector<double> us;
    [[nodiscard]] double share(double of) {
        if (us.empty()) return NAN;
        std::ranges::sort(us);
        return us[static_cast<std::size_t>(of * static_cast<double>(us.size() - 1))];
    }
};

// Things that are no target: texture, bars across it, bright boxes.
test::TestPicture clutter(const test::TrackingScene& scene, int i) {
    test::TestPicture p{scene.width, scene.height, 90};
    p.texture({0, 0, scene.width, scene.height}, {3.3 * i, 0}, 10, 3);
    for (int k = 0; k < 6; ++k) {
        const double x = scene.width * (k + 0.3) / 6, y = scene.height * ((k * 5) % 7) / 9.0;
        p.rectangle(x, y, x + 0.08 * scene.width, y + 0.4 * scene.height, 160, 0.8);
    }
    return p;
}

bench::Row loss_row(const test::TrackingScene& scene) {
    std::mt19937_64 random{5};
    tracking::ViewTracker tracker{scene.view};
    std::int64_t tick = 0;
    Costs learn, follow, dark, cluttered, back;
    int wrong = 0, waited = 0;
    double origin = 0;
    const auto update = [&](const test::TestPicture& picture, Costs& costs) {
        const test::Shot shot = picture.expose({.noise = noise}, random);
        const double before = bench::cpu_ns();
        const tracking::Fix fix = tracker.update(shot.view(), CameraTick{tick++}).front();
        costs.us.push_back(1e-3 * (bench::cpu_ns() - before));
        return fix;
    };
    origin = update(scene.picture({0, 0}), learn).x_px;
    Costs warm;
    for (int i = 0; i < 64; ++i) update(scene.picture({0.06 * (i % 17), 0.06 * (i % 15)}), warm);
    for (int i = 0; i < 160; ++i) update(scene.picture({1.5 * std::sin(0.2 * i), 0}), follow);
    for (int i = 0; i < 20; ++i) {
        test::TestPicture p{scene.width, scene.height, 70};
        wrong += found(update(p, dark).state) ? 1 : 0;
    }
    const std::vector<test::TestPicture> things{clutter(scene, 0), clutter(scene, 1), clutter(scene, 2)};
    for (std::size_t i = 0; i < 60; ++i) wrong += found(update(things[i % 3], cluttered).state) ? 1 : 0;
    const bool anywhere = scene.name != "dots" && scene.name != "bars";
    const double shift = anywhere ? 0.1 * scene.width : 0.2;
    for (bool seen = false; !seen && waited < 200; ++waited) {
        const tracking::Fix fix = update(scene.picture({shift, 0}), back);
        seen = found(fix.state);
        if (seen && std::abs(fix.x_px - origin - shift) > 0.5) ++wrong;
    }
    return {{"kind", scene.name},
            {"picture", std::to_string(scene.width) + "x" + std::to_string(scene.height)},
            {"learning", learn.share(1), "us"},
            {"follow p50", follow.share(0.5), "us"},
            {"follow worst", follow.share(1), "us"},
            {"first pictures worst", warm.share(1), "us"},
            {"dark worst", dark.share(1), "us"},
            {"clutter p50", cluttered.share(0.5), "us"},
            {"clutter worst", cluttered.share(1), "us"},
            {"found again worst", back.share(1), "us"},
            {"found after", static_cast<double>(waited), "pictures"},
            {"wrong", static_cast<double>(wrong)}};
}

// A disc of 200 px in the picture of the paper.
test::TrackingScene wide_disc() {
    test::TrackingScene scene = test::tracking_scene("disc");
    scene.name = "wide disc";
    scene.width = 1280, scene.height = 256;
    Target& target = scene.view.targets.front();
    target.diameter_mm = 50;
    target.roi_px = {400, 20, 216, 216};
    scene.draw = [](test::TestPicture& p, tracking::Point s, const test::Look&) {
        p.disc(tracking::Point{508.3, 127.8} + s, 100, 160, 0.8);
    };
    return scene;
}

test::TrackingScene wide_dot() {
    test::TrackingScene scene = wide_disc();
    scene.name = "wide dot";
    Target& target = scene.view.targets.front();
    target.diameter_mm = 3;
    target.roi_px = {495, 115, 28, 28};
    scene.draw = [](test::TestPicture& p, tracking::Point s, const test::Look&) {
        p.disc(tracking::Point{508.3, 127.8} + s, 6, 160, 0.8);
    };
    return scene;
}

// The nominal scene of one view: a walker 600 px wide above a strip of bars, which is the base.
test::TrackingScene nominal_view(bool top) {
    test::TrackingScene scene = test::tracking_scene("paper");
    Target walker{"walker", top ? TargetKind::disc : TargetKind::rectangle}, base{"base", TargetKind::bars};
    walker.diameter_mm = walker.width_mm = 150;
    walker.roi_px = {320, 0, 640, 206};
    base.pitch_mm = 4;
    base.roi_px = {40, 212, 1200, 44};
    scene.view.targets = {walker, base};
    scene.draw = [top](test::TestPicture& p, tracking::Point s, const test::Look& look) {
        if (top)
            p.disc(tracking::Point{640.3, 103.2} + s, 300, 160, look.blur);
        else
            p.rectangle(340.3 + s.x, -9, 940.3 + s.x, 400, 160, look.blur);
        p.cover({0, 206, p.width(), p.height()}, 60);
        p.bars(640.2 + 0.6 * s.x, 16, 212, 256, 60, 160, look.blur);
    };
    return scene;
}

// Walker and base in both views: cost of a pair of pictures.
bench::Row pair_row() {
    const test::TrackingScene top = nominal_view(true), side = nominal_view(false);
    const Movie above = movie_of(top), beside = movie_of(side);
    tracking::ViewTracker in_top{top.view}, in_side{side.view};
    Costs costs;
    std::array<std::vector<double>, 4> errors;
    std::int64_t tick = 0;
    for (int round = 0; round < 40; ++round) {
        for (std::size_t n = 0; n < above.shots.size(); ++n) {
            const std::size_t i = round % 2 == 0 ? n : above.shots.size() - 1 - n;  // without jumps
            const double before = bench::cpu_ns();
            const auto a = in_top.update(above.shots[i].view(), CameraTick{tick});
            const auto b = in_side.update(beside.shots[i].view(), CameraTick{tick++});
            const double us = 1e-3 * (bench::cpu_ns() - before);
            if (round == 0) continue;
            costs.us.push_back(us);
            const double s = above.shift[i];
            errors[0].push_back(a[0].x_px - s);
            errors[1].push_back(a[1].x_px - 0.6 * s);
            errors[2].push_back(b[0].x_px - s);
            errors[3].push_back(b[1].x_px - 0.6 * s);
        }
    }
    return {{"picture", "1280x256"},
            {"pairs", static_cast<double>(costs.us.size())},
            {"p50", costs.share(0.5), "us"},
            {"p99.9", costs.share(0.999), "us"},
            {"walker rms, top", rms_about_mean(errors[0]), "px"},
            {"walker rms, side", rms_about_mean(errors[2]), "px"},
            {"base rms, top", rms_about_mean(errors[1]), "px"},
            {"base rms, side", rms_about_mean(errors[3]), "px"},
            {"share of a core at 1000 pairs/s", costs.share(0.5) / 10, "%"}};
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) {
    using namespace shaker;
    cv::setNumThreads(1);
    bench::Table table;
    if (argc > 1 && std::string_view{argv[1]} == "--losses") {
        for (const test::TrackingScene& scene : test::tracking_scenes()) table.add(loss_row(scene));
        table.add(loss_row(wide_disc()));
        table.add(loss_row(wide_dot()));
        table.print(argc, argv);
        return 0;
    }
    if (argc > 1 && std::string_view{argv[1]} == "--pair") {
        table.add(pair_row());
        table.print(argc, argv);
        return 0;
    }
    for (const test::TrackingScene& scene : test::tracking_scenes()) {
        const Movie movie = movie_of(scene);
        table.add(row(scene, "this", by_tracker(scene, movie)));
        table.add(row(scene, "matchTemplate + parabola", by_match_template(scene, movie)));
        table.add(row(scene, "phaseCorrelate, Hann", by_phase_correlation(scene, movie)));
    }
    table.print(argc, argv);
    return 0;
}
