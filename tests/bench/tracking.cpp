// Tracking: cost and error of each kind against its bound, after 3000 pictures, beside other methods on the
// same frames; with --losses the cost of pictures in which a target is learned, lost and found again, with
// --pair that of walker and base in both views of the nominal scene, with --share cost and error with fewer
// rows and other bits, with --footage the spread of distances between dots of real footage
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core/utility.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "tests/bench/table.hpp"
#include "tests/support/cost.hpp"
#include "tests/support/rms.hpp"
#include "tests/support/shared_data.hpp"
#include "tests/support/tracking/building_swing.hpp"
#include "tests/support/tracking/grey_movie.hpp"
#include "tests/support/tracking/peers.hpp"
#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker {
namespace {

using test::rms_about_mean;

constexpr int frames = 100, first_pictures = 3000;
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

// A walk that ends where it began: the movie can be shown again without a jump.
Movie movie_of(const test::TrackingScene& scene, const test::Exposure& exposure = {.noise = noise}) {
    Movie movie;
    std::mt19937_64 random{17};
    std::uniform_real_distribution<double> step{-0.4, 0.4};
    double shift = 0;
    for (int i = 0; i < frames; ++i, shift += step(random)) movie.shift.push_back(shift);
    for (std::size_t i = 0; i < frames; ++i) {
        movie.shift[i] -= shift * static_cast<double>(i) / frames;
        movie.shots.push_back(scene.picture({movie.shift[i], 0}).expose(exposure, random));
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

double median(std::vector<double> v) {
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return *middle;
}

Result by_tracker(const test::TrackingScene& scene, const Movie& movie) {
    test::Follower follow{scene.view};
    // Filters are computed ahead of need in the first pictures, whatever they show.
    for (std::size_t i = 0; i < first_pictures; ++i) follow(movie.shots[i % 5]);
    std::vector<double> sds;
    Result result = measure(movie, [&](const test::Shot& shot) {
        const tracking::Fix fix = follow(shot);
        if (found(fix.state)) sds.push_back(fix.sd_px);
        return fix.x_px;
    });
    result.sd_px = median(sds);
    return result;
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

// Targets in a picture of the paper's size.
test::TrackingScene wide(const std::string& name, const Target& target,
                         std::function<void(test::TestPicture&, tracking::Point)> draw) {
    test::TrackingScene scene = test::tracking_scene("disc");
    scene.name = name;
    scene.width = 1280, scene.height = 256;
    scene.bound = [](double) { return NAN; };
    scene.view.targets = {target};
    scene.draw = [draw = std::move(draw)](test::TestPicture& p, tracking::Point s, const test::Look&) {
        draw(p, s);
    };
    return scene;
}

test::TrackingScene wide_disc(const std::string& name, double radius) {
    const int half = static_cast<int>(radius) + 8;
    Target target = test::tracking_scene("disc").view.targets.front();
    target.diameter_mm = 0.5 * radius;
    target.roi_px = {508 - half, 128 - half, 2 * half, 2 * half};
    return wide(name, target, [radius](test::TestPicture& p, tracking::Point s) {
        p.disc(tracking::Point{508.3, 127.8} + s, radius, 160, 0.8);
    });
}

// A textured plate of 160 x 112 px.
test::TrackingScene wide_patch() {
    Target target{"patch", TargetKind::patch};
    target.roi_px = {444, 80, 128, 96};
    return wide("wide patch", target, [](test::TestPicture& p, tracking::Point s) {
        const int x = static_cast<int>(std::lround(s.x)), y = static_cast<int>(std::lround(s.y));
        p.texture({428 + x, 72 + y, 588 + x, 184 + y}, s, 25, 11);
    });
}

// A side view of 600 x 199 px.
test::TrackingScene wide_rectangle() {
    Target target{"rectangle", TargetKind::rectangle};
    target.width_mm = 150;
    target.roi_px = {320, 20, 640, 220};
    return wide("wide rectangle", target, [](test::TestPicture& p, tracking::Point s) {
        p.rectangle(340.3 + s.x, 40 + s.y, 940.3 + s.x, 239 + s.y, 160, 0.8);
    });
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
    // A second of pictures, in which filters are computed, is left out.
    constexpr int first_round = 10, rounds = 80;
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t i = 0; i < above.shots.size(); ++i) {
            const double before = bench::cpu_ns();
            const auto a = in_top.update(above.shots[i].view(), CameraTick{tick});
            const auto b = in_side.update(beside.shots[i].view(), CameraTick{tick++});
            const double us = 1e-3 * (bench::cpu_ns() - before);
            if (round < first_round) continue;
            costs.us.push_back(us);
            const double s = above.shift[i];
            errors[0].push_back(a[0].x_px - s);
            errors[1].push_back(a[1].x_px - 0.6 * s);
            errors[2].push_back(b[0].x_px - s);
            errors[3].push_back(b[1].x_px - 0.6 * s);
        }
    }
    return {{"picture", "1280x256, after a second"},
            {"pairs", static_cast<double>(costs.us.size())},
            {"p50", costs.share(0.5), "us"},
            {"p99.9", costs.share(0.999), "us"},
            {"walker rms, top", rms_about_mean(errors[0]), "px"},
            {"walker rms, side", rms_about_mean(errors[2]), "px"},
            {"base rms, top", rms_about_mean(errors[1]), "px"},
            {"base rms, side", rms_about_mean(errors[3]), "px"},
            {"share of a core at 1000 pairs/s", costs.share(0.5) / 10, "%"}};
}

// The middle rows of the region only: 1/1 to 1/16 of them, for kinds with straight edges across x.
void add_rows(bench::Table& table) {
    for (const char* name : {"rectangle", "bars"}) {
        for (int part = 1; part <= 16; part *= 2) {
            test::TrackingScene scene = test::tracking_scene(name);
            auto& [x, y, width, height] = scene.view.targets.front().roi_px;
            const int all = height, rows = std::max(4, height / part);
            y += (height - rows) / 2, height = rows;
            bench::Row r = row(scene, "this", by_tracker(scene, movie_of(scene)));
            r[5].value = std::get<double>(r[5].value) * std::sqrt(static_cast<double>(all) / rows);
            r[1].value = std::to_string(rows) + " of " + std::to_string(all) + " rows";
            table.add(std::move(r));
        }
    }
}

// The same light on sensors of 8 to 16 bits. Noise and contrast are the same shares of full scale.
void add_bits(bench::Table& table) {
    for (const test::TrackingScene& scene : test::tracking_scenes()) {
        for (const int bits : {8, 10, 12, 16}) {
            const double depth = std::exp2(bits - 8);
            const test::Exposure exposure{.bytes_per_pixel = bits > 8 ? 2 : 1,
                                          .noise = noise,
                                          .depth = depth,
                                          .full = std::exp2(bits) - 1};
            table.add(
                row(scene, std::to_string(bits) + " bits", by_tracker(scene, movie_of(scene, exposure))));
        }
    }
}

// Spread of the distances between neighbouring dots of a beam, px, less a parabola in the beam's place, which
// the lens causes.
double spread(const std::vector<test::DotPlaces>& places) {
    const auto frames_seen = static_cast<Eigen::Index>(places.size());
    Eigen::MatrixX3d powers(frames_seen, 3);
    double sum = 0;
    const std::size_t gaps = places.front().size() - 1;
    for (std::size_t k = 0; k < gaps; ++k) {
        Eigen::VectorXd gap(frames_seen);
        for (Eigen::Index i = 0; i < frames_seen; ++i) {
            const test::DotPlaces& p = places[static_cast<std::size_t>(i)];
            const double place = (p[k].x - places.front()[k].x) / 100;
            gap[i] = length(p[k + 1] - p[k]);
            powers.row(i) << 1, place, place * place;
        }
        const Eigen::VectorXd left = gap - powers * powers.colPivHouseholderQr().solve(gap);
        sum += left.squaredNorm() / static_cast<double>(frames_seen);
    }
    return std::sqrt(sum / static_cast<double>(gaps));
}

void add_footage(bench::Table& table) {
    const std::filesystem::path folder = shared_data("building-swing");
    if (folder.empty()) {
        std::fprintf(stderr, "%s\n", missing_data("building-swing").c_str());
        return;
    }
    for (const char* beam : {"bottom", "top"}) {
        const std::vector<test::Shot> movie = test::grey_movie(folder / (std::string{beam} + ".mkv"));
        const double before = bench::cpu_ns();
        std::vector<test::DotPlaces> ours;
        for (const auto& fixes : test::follow(test::beam_view(beam), movie)) {
            ours.emplace_back();
            for (const tracking::Fix& f : fixes) ours.back().push_back({f.x_px, f.y_px});
        }
        const auto add = [&](const std::string& method, double from,
                             const std::vector<test::DotPlaces>& all) {
            table.add(
                {{"beam", beam},
                 {"method", method},
                 {"cost", 1e-3 * (bench::cpu_ns() - from) / static_cast<double>(movie.size()), "us/frame"},
                 {"spread", spread(all), "px"},
                 {"frames", static_cast<double>(movie.size())}});
        };
        add("this", before, ours);
        for (const test::DotPeer& peer : test::dot_peers(movie, ours)) {
            const double begin = bench::cpu_ns();
            std::vector<test::DotPlaces> all;
            for (std::size_t i = 0; i < movie.size(); ++i) all.push_back(peer.find(movie[i], ours[i]));
            add(peer.name, begin, all);
        }
    }
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) {
    using namespace shaker;
    cv::setNumThreads(1);
    bench::Table table;
    const std::string_view part = argc > 1 ? argv[1] : "";
    if (part == "--losses") {
        for (const test::TrackingScene& scene : test::tracking_scenes()) table.add(loss_row(scene));
        table.add(loss_row(wide_disc("wide disc", 100)));
        table.add(loss_row(wide_disc("wide dot", 6)));
        table.add(loss_row(wide_patch()));
    } else if (part == "--pair") {
        table.add(pair_row());
    } else if (part == "--share") {
        add_rows(table);
        add_bits(table);
    } else if (part == "--footage") {
        add_footage(table);
    } else {
        std::vector<test::TrackingScene> scenes = test::tracking_scenes();
        scenes.push_back(wide_disc("wide disc", 100));
        scenes.push_back(wide_rectangle());
        for (const test::TrackingScene& scene : scenes) {
            const Movie movie = movie_of(scene);
            table.add(row(scene, "this", by_tracker(scene, movie)));
            for (const test::Peer& peer : test::peers_of(scene))
                table.add(row(scene, peer.name, measure(movie, peer.find)));
        }
    }
    table.print(argc, argv);
    return 0;
}
