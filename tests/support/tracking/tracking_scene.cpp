#include "tests/support/tracking/tracking_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "drivers/optics/bar_code.hpp"

namespace shaker::test {
namespace {

constexpr double dark = 60, bright = 160;
const double edge_sigma = std::sqrt(Look{}.blur * Look{}.blur + 1.0 / 12);

// sigma / (C sqrt(n / (2 sqrt(pi) s))) for n rows of one edge.
double edge_bound(double noise, double rows) {
    const double quantised = std::sqrt(noise * noise + 1.0 / 12);
    return quantised / ((bright - dark) * std::sqrt(rows / (2 * std::sqrt(std::numbers::pi) * edge_sigma)));
}

View one_target(Target target) {
    View view;
    view.camera = "test";
    view.mm_per_px = 0.25;
    view.targets = {std::move(target)};
    return view;
}

TrackingScene disc_scene(const std::string& name, double radius, int width, int height) {
    const tracking::Point middle{0.5 * width + 0.3, 0.5 * height - 0.2};
    Target target{name, TargetKind::disc};
    target.diameter_mm = 0.5 * radius;
    const int rx = std::min(static_cast<int>(radius) + 8, width / 2);
    const int ry = std::min(static_cast<int>(radius) + 8, height / 2);
    target.roi_px = {width / 2 - rx, height / 2 - ry, 2 * rx, 2 * ry};
    // Each visible arc spans twice this angle. Only the visible rim, weighted by its slope, determines x.
    const double half = std::asin(std::min(1.0, 0.5 * height / radius));
    const double rim = 4 * radius * (0.5 * half + 0.25 * std::sin(2 * half));
    return {name,
            one_target(target),
            width,
            height,
            bright - dark,
            [=](TestPicture& p, tracking::Point shift, const Look& look) {
                p.disc(middle + shift, look.size * radius, bright, look.blur);
            },
            [=](double noise) { return edge_bound(noise, rim); }};
}

// A disc beside another one that is no target.
TrackingScene twin_scene() {
    TrackingScene scene = disc_scene("twin", 50, 420, 144);
    const auto alone = scene.draw;
    scene.draw = [alone](TestPicture& p, tracking::Point shift, const Look& look) {
        alone(p, shift, look);
        p.disc(tracking::Point{350.2, 71.6} + shift, look.size * 50, bright, look.blur);
    };
    return scene;
}

TrackingScene rectangle_scene() {
    Target target{"rectangle", TargetKind::rectangle};
    target.width_mm = 20;
    target.roi_px = {70, 20, 116, 50};
    return {"rectangle",
            one_target(target),
            256,
            96,
            bright - dark,
            [](TestPicture& p, tracking::Point s, const Look& look) {
                const double half = look.size * 40;
                p.rectangle(128.3 + s.x - half, 25 + s.y, 128.3 + s.x + half, 90, bright, look.blur);
            },
            [](double noise) { return edge_bound(noise, 2 * 40); }};
}

TrackingScene dots_scene() {
    Target target{"dots", TargetKind::dots};
    target.diameter_mm = 2.6;
    target.pitch_mm = 8;
    target.polarity = Polarity::dark;
    target.roi_px = {24, 4, 212, 24};
    return {"dots",
            one_target(target),
            256,
            32,
            bright - dark,
            [](TestPicture& p, tracking::Point s, const Look& look) {
                p.rectangle(-50, 2, 400, 30, bright, look.blur);
                for (int k = -4; k < 7; ++k)
                    p.disc({127.2 + look.size * (32 * k - 16) + s.x, 16.1 + s.y}, look.size * 5.2, dark,
                           look.blur);
            },
            [](double noise) { return edge_bound(noise, 6 * std::numbers::pi * 5.2); }};
}

TrackingScene bars_scene() {
    Target target{"bars", TargetKind::bars};
    target.pitch_mm = 5;
    target.roi_px = {24, 4, 208, 24};
    return {"bars",
            one_target(target),
            256,
            32,
            bright - dark,
            [](TestPicture& p, tracking::Point s, const Look& look) {
                p.bars(120.3 + s.x, 20 * look.size, 2, 30, dark, bright, look.blur);
            },
            [](double noise) { return edge_bound(noise, 24 * 208 / 10.0); }};
}

// Bars of 6 to 20 px over most of the picture's width, as a printed strip has them.
TrackingScene code_scene(const std::string& name, int width, int height, int top, int bottom) {
    Target target{name, TargetKind::code};
    target.roi_px = {24, top + 2, width - 48, bottom - top - 4};
    const std::vector<double> edges = optics::edges_of(
        {.seed = 3, .length_mm = static_cast<double>(width - 12), .least_mm = 6, .most_mm = 20});
    const auto seen = std::ranges::count_if(edges, [&](double e) { return e > 22 && e < width - 26; });
    return {name,
            one_target(target),
            width,
            height,
            bright - dark,
            [=](TestPicture& p, tracking::Point s, const Look& look) {
                std::vector<double> at = edges;
                for (double& e : at) e = 0.5 * width + look.size * (e + 2.3 - 0.5 * width) + s.x;
                p.code(at, top, bottom, dark, bright, look.blur);
            },
            [=](double noise) { return edge_bound(noise, static_cast<double>((bottom - top - 4) * seen)); }};
}

TrackingScene patch_scene() {
    Target target{"patch", TargetKind::patch};
    target.roi_px = {40, 16, 64, 64};
    return {"patch",
            one_target(target),
            192,
            96,
            60,
            [](TestPicture& p, tracking::Point s, const Look& look) {
                p.texture({0, 0, 144, 96}, s, 25, 11, look.turn);
            },
            [](double) { return std::numeric_limits<double>::quiet_NaN(); }};
}

}  // namespace

TestPicture TrackingScene::picture(tracking::Point shift, const Look& look) const {
    TestPicture p{width, height, name == "patch" ? 120 : dark};
    draw(p, shift, look);
    return p;
}

std::vector<TrackingScene> tracking_scenes() {
    return {disc_scene("disc", 50, 256, 144),
            disc_scene("dot", 6, 96, 64),
            disc_scene("arcs", 120, 320, 96),
            disc_scene("paper", 300, 1280, 256),
            twin_scene(),
            rectangle_scene(),
            dots_scene(),
            bars_scene(),
            patch_scene(),
            code_scene("code", 256, 32, 2, 30),
            code_scene("wide code", 1280, 256, 208, 256)};
}

const TrackingScene& tracking_scene(const std::string& name) {
    static const std::vector<TrackingScene> all = tracking_scenes();
    for (const TrackingScene& scene : all) {
        if (scene.name == name) return scene;
    }
    throw std::out_of_range{"no tracking scene " + name};
}

}  // namespace shaker::test
