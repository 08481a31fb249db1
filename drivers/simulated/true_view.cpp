#include "drivers/simulated/true_view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>

namespace shaker::simulated {

namespace {

// A generator whose state is a hash of the arguments (splitmix64).
std::minstd_rand generator(std::uint64_t seed, std::uint64_t tick) {
    std::uint64_t z = seed + 0x9e3779b97f4a7c15ULL * (tick + 1);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return std::minstd_rand{static_cast<std::uint_fast32_t>((z ^ (z >> 31U)) % 2147483646U + 1)};
}

constexpr double degree = std::numbers::pi / 180;

}  // namespace

View true_view(const CameraTruth& camera) {
    View view = camera.view;
    const TrueOptics& t = camera.optics;
    if (t.mm_per_px > 0) view.mm_per_px = t.mm_per_px;
    if (t.distance_mm > 0) view.distance_mm = t.distance_mm;
    if (t.k1 == 0 && t.k2 == 0 && t.tilt_x_deg == 0 && t.tilt_y_deg == 0 && t.turn_deg == 0) return view;
    const double c = std::cos(degree * t.turn_deg), s = std::sin(degree * t.turn_deg);
    view.along = {c * view.along[0] - s * view.along[1], s * view.along[0] + c * view.along[1]};
    view.tilt_deg = {t.tilt_x_deg, t.tilt_y_deg};
    view.lens = {.centre_px = {0.5 * (camera.width - 1), 0.5 * (camera.height - 1)},
                 .focal_px = view.distance_mm > 0 ? view.distance_mm / view.mm_per_px : camera.width,
                 .k1 = t.k1,
                 .k2 = t.k2};
    return view;
}

optics::Point seen_at(const View& truth, double offset_mm, double position_m, double centre_x, double row,
                      double px_per_m) noexcept {
    const double moved = truth.along[0] * position_m * px_per_m;
    if (truth.lens.focal_px <= 0) return {centre_x + moved, row};
    const optics::Point zero = optics::place_at(truth, offset_mm, {centre_x, row});
    return optics::image_of(truth, offset_mm, {zero[0] + 1e3 * position_m, zero[1]});
}

std::vector<std::array<double, 4>> board_places(const std::string& text) {
    std::istringstream in{text};
    std::vector<double> numbers;
    for (double x{}; in >> x;) numbers.push_back(x);
    if (!in.eof() || numbers.size() % 4 != 0) return {};
    std::vector<std::array<double, 4>> places(numbers.size() / 4);
    for (std::size_t i = 0; i < numbers.size(); ++i) places[i / 4][i % 4] = numbers[i];
    return places;
}

ShownBoards::ShownBoards(const CameraTruth& camera) : each_s_{camera.board_s} {
    const View truth = true_view(camera);
    const optics::Board board;
    const optics::Point middle{-0.5 * board.columns * board.square_mm, -0.5 * board.rows * board.square_mm};
    for (const auto& [a, b, turn, height] : board_places(camera.boards)) {
        const optics::Point centre =
            optics::place_at(truth, height, {0.5 * (camera.width - 1), 0.5 * (camera.height - 1)});
        optics::BoardPose pose{{centre[0] + a, centre[1] + b}, turn * degree, height};
        pose.origin_mm = pose.place_of(middle);
        poses_.push_back(pose);
    }
}

optics::BoardPose ShownBoards::at(double t) const noexcept {
    constexpr double moving = 0.25;
    const double place = std::clamp(t / each_s_, 0.0, static_cast<double>(poses_.size()) - 0.5);
    const auto k = static_cast<std::size_t>(place);
    const double share = (place - static_cast<double>(k)) / moving;
    optics::BoardPose pose = poses_[k];
    if (k == 0 || share >= 1) return pose;
    const optics::BoardPose& before = poses_[k - 1];
    const auto between = [&](double from, double to) { return from + share * (to - from); };
    for (std::size_t i = 0; i < 2; ++i) pose.origin_mm[i] = between(before.origin_mm[i], pose.origin_mm[i]);
    pose.turn_rad = between(before.turn_rad, pose.turn_rad);
    return pose;
}

std::vector<Sighting> sightings(const CameraTruth& camera, const PictureLayout& layout,
                                std::span<const Pose> poses, CameraTick tick, bool walker,
                                std::uint64_t seed) {
    Pose mean{};
    for (const Pose& p : poses) {
        mean.base += p.base / static_cast<double>(poses.size());
        mean.walker += p.walker / static_cast<double>(poses.size());
    }
    std::minstd_rand random = generator(seed, static_cast<std::uint64_t>(tick.n));
    std::normal_distribution<double> noise{0, sighting_sd_px};
    std::vector<Sighting> found;
    const View truth = true_view(camera);
    found.reserve(camera.view.targets.size());
    for (const Target& target : camera.view.targets) {
        const bool base = target.name == "base";
        const double row = base ? 0.5 * (layout.marks_top + layout.marks_bottom) : layout.walker_y;
        const auto [x, y] = seen_at(truth, target.offset_mm, base ? mean.base : mean.walker, layout.centre_x,
                                    row, base ? layout.base_px_per_m : layout.walker_px_per_m);
        const Sighting s{x + noise(random), y + noise(random), sighting_sd_px};
        const bool seen = base || (walker && x >= 0 && x <= camera.width - 1);
        found.push_back(seen ? s : Sighting{});
    }
    return found;
}

}  // namespace shaker::simulated
