#include "tracking/image/outline_bank.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tracking/image/edge_profile.hpp"

namespace shaker::tracking {
namespace {

using Lanes [[gnu::vector_size(16)]] = float;

constexpr double least_spread = 0.02;  // of E within a block, as in EdgeFit
constexpr double farthest_step = 1.5;  // px
constexpr double farthest = 3;         // px from the start

}  // namespace

void OutlineBank::shape(const Shape& shape, std::vector<Site> sites, const std::vector<Point>& shifts) {
    shape_ = shape;
    sites_ = std::move(sites);
    ranges_.assign(shifts.size(), {});
    for (std::size_t b = 0; b < shifts.size(); ++b) ranges_[b].shift = shifts[b];
    for (std::size_t i = 0; i < sites_.size(); ++i) {
        const Site& s = sites_[i];
        Range& r = ranges_[static_cast<std::size_t>(s.block)];
        if (r.end == 0) r = {static_cast<int>(i), 0, s.x, s.y, s.x, s.y, r.shift};
        r.end = static_cast<int>(i) + 1;
        r.x0 = std::min(r.x0, s.x);
        r.x1 = std::max(r.x1, s.x);
        r.y0 = std::min(r.y0, s.y);
        r.y1 = std::max(r.y1, s.y);
    }
    blocks_.assign(phases * phases * ranges_.size(), {});
    weights_ = std::make_unique_for_overwrite<Weights[]>(phases * phases * sites_.size());
    seen_.assign(ranges_.size(), {});
    sorted_.reserve(ranges_.size());
    columns_.resize(sites_.size());
}

void OutlineBank::set_blur(double blur) noexcept {
    shape_.blur = blur;
    for (Block& b : blocks_) b.known = false;
}

void OutlineBank::learn(std::size_t place, std::size_t b, Point offset) {
    const bool plane = shape_.ground == EdgeFit::Ground::plane;
    const int nuisances = plane ? 4 : 2;
    const Range& range = ranges_[b];
    Weights* const weights = &weights_[place * sites_.size()];
    Eigen::Matrix4d ground = Eigen::Matrix4d::Zero();
    Eigen::Matrix<double, 4, 3> cross = Eigen::Matrix<double, 4, 3>::Zero();
    Block& block = blocks_[place * ranges_.size() + b];
    block.known = true;
    block.outline = 0;
    block.ground.setZero();
    block.normal.setZero();
    for (int i = range.begin; i < range.end; ++i) {
        const Site& s = sites_[static_cast<std::size_t>(i)];
        const double du = s.x - range.shift.x - offset.x, dv = s.y - range.shift.y - offset.y;
        const double r = std::sqrt(du * du + dv * dv);
        const auto [e, slope] = EdgeProfile::at((shape_.size - r) / shape_.blur);
        const double g = slope / shape_.blur, per_r = r > 1e-9 ? g / r : 0;
        auto& c = columns_[static_cast<std::size_t>(i)];
        c = {1, e, static_cast<double>(s.x), static_cast<double>(s.y), du * per_r, dv * per_r, g, 0};
        for (int j = 0; j < nuisances; ++j) {
            for (int k = 0; k < nuisances; ++k)
                ground(j, k) += c[static_cast<std::size_t>(j)] * c[static_cast<std::size_t>(k)];
            for (int k = 0; k < 3; ++k)
                cross(j, k) += c[static_cast<std::size_t>(j)] * c[static_cast<std::size_t>(4 + k)];
        }
        block.outline += g;
    }
    const double n = ground(0, 0), spread = ground(1, 1) - ground(0, 1) * ground(0, 1) / std::max(n, 1.0);
    if (!(spread > least_spread * n) || n < nuisances + 3) {
        for (int i = range.begin; i < range.end; ++i) weights[i] = {};
        return;
    }
    block.ground.topLeftCorner(nuisances, nuisances) = ground.topLeftCorner(nuisances, nuisances).inverse();
    const Eigen::Matrix<double, 4, 3> explained = block.ground * cross;
    for (int i = range.begin; i < range.end; ++i) {
        const auto& c = columns_[static_cast<std::size_t>(i)];
        Eigen::Vector3d own{c[4], c[5], c[6]};
        for (int j = 0; j < nuisances; ++j)
            own -= explained.row(j).transpose() * c[static_cast<std::size_t>(j)];
        block.normal += own * own.transpose();
        weights[i] = {static_cast<float>(c[1]), static_cast<float>(own[0]), static_cast<float>(own[1]),
                      static_cast<float>(own[2])};
    }
}

template <class T>
void OutlineBank::look(const Pixels<T>& pixels, std::size_t place, Point offset, int x, int y, int width,
                       int height) {
    const bool plane = shape_.ground == EdgeFit::Ground::plane;
    const int level = static_cast<int>(shape_.level), nuisances = plane ? 4 : 2;
    for (std::size_t b = 0; b < ranges_.size(); ++b) {
        const Range& range = ranges_[b];
        Seen& seen = seen_[b];
        seen.used = false;
        const bool in_view = range.end > 0 && x + range.x0 >= 0 && x + range.x1 < width &&
                             y + range.y0 >= 0 && y + range.y1 < height;
        if (!in_view) continue;
        const Block& block = block_at(place, b);
        if (!block.known) learn(place, b, offset);
        if (block.normal(2, 2) == 0) continue;
        const Weights* const weights = &weights_[place * sites_.size()];
        Lanes sums{}, more{};
        std::int64_t sum = 0, squares = 0, along = 0, across = 0;
        for (int i = range.begin; i < range.end; ++i) {
            const Site& s = sites_[static_cast<std::size_t>(i)];
            const int value = static_cast<int>(pixels.row(y + s.y)[x + s.x]) - level;
            const auto& w = weights[i];
            Lanes lanes{w[0], w[1], w[2], w[3]};
            (i % 2 == 0 ? sums : more) += static_cast<float>(value) * lanes;
            sum += value;
            squares += std::int64_t{value} * value;
            if (plane) {
                along += std::int64_t{value} * s.x;
                across += std::int64_t{value} * s.y;
            }
        }
        sums += more;
        const Eigen::Vector4d n{static_cast<double>(sum), static_cast<double>(sums[0]),
                                static_cast<double>(along), static_cast<double>(across)};
        const Eigen::Vector4d ground = block.ground * n;
        seen.gain = ground[1];
        seen.freedom = range.end - range.begin - nuisances;
        seen.variance = std::max(static_cast<double>(squares) - n.dot(ground), 0.0) / seen.freedom;
        seen.score = seen.gain * Eigen::Vector3d{sums[1], sums[2], sums[3]};
        seen.used = true;
    }
}

double OutlineBank::median_of(double Seen::*member) {
    sorted_.clear();
    for (const Seen& s : seen_)
        if (s.used) sorted_.push_back(s.*member);
    if (sorted_.empty()) return 0;
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
    std::nth_element(sorted_.begin(), middle, sorted_.end());
    return *middle;
}

// As in EdgeFit: a block whose gain or residual differs from the others' does not show the outline.
void OutlineBank::choose_blocks() {
    contrast_ = median_of(&Seen::gain);
    const double variance = median_of(&Seen::variance);
    for (Seen& s : seen_) {
        const double ratio = s.gain / contrast_;
        s.used = s.used && ratio > 0.4 && ratio < 2.5 && s.variance <= 16 * variance + 1e-9;
    }
}

// How far blocks disagree beyond their noise and learned offsets: a factor of the variance, at least 1.
double OutlineBank::disagreement(std::size_t place, const Eigen::Vector3d& change, double variance) {
    double squares = 0, count = 0;
    for (std::size_t b = 0; b < seen_.size(); ++b) {
        Seen& s = seen_[b];
        if (!s.used) continue;
        const Eigen::Matrix3d normal = s.gain * s.gain * block_at(place, b).normal;
        s.off = (s.score - normal * change)[2] / normal(2, 2);
        const double known = s.habit_frames > 0 ? 1 + 1 / s.habit_frames : 1;
        squares += (s.off - s.habit) * (s.off - s.habit) * normal(2, 2) / (variance * known);
        count += 1;
    }
    return count > 6 ? std::max(1.0, squares / (count - 4)) : 1;
}

void OutlineBank::accept() {
    for (Seen& s : seen_) {
        if (!s.used) continue;
        s.habit_frames = std::min(s.habit_frames + 1, EdgeFit::longest_memory);
        s.habit += (s.off - s.habit) / s.habit_frames;
    }
}

EdgeFitResult OutlineBank::fit(const ImageView& image, Point start) {
    Point at = start;
    double size = shape_.size;
    EdgeFitResult result;
    for (int step = 0; step < most_steps; ++step) {
        const int x = static_cast<int>(std::floor(at.x + 0.5)), y = static_cast<int>(std::floor(at.y + 0.5));
        const auto phase = [](double off) {
            return std::clamp(static_cast<int>((off + 0.5) * phases), 0, phases - 1);
        };
        const int i = phase(at.x - x), j = phase(at.y - y);
        const Point offset{(i + 0.5) / phases - 0.5, (j + 0.5) / phases - 0.5};
        const auto place = static_cast<std::size_t>(j * phases + i);
        with_pixels(image,
                    [&](auto pixels) { look(pixels, place, offset, x, y, image.width, image.height); });
        const auto looked = static_cast<double>(std::ranges::count_if(seen_, &Seen::used));
        choose_blocks();
        Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
        Eigen::Vector3d score = Eigen::Vector3d::Zero();
        double freedom = 0, variance = 0, outline = 0, used = 0;
        for (std::size_t b = 0; b < seen_.size(); ++b) {
            const Seen& s = seen_[b];
            if (!s.used) continue;
            normal += s.gain * s.gain * block_at(place, b).normal;
            score += s.score;
            freedom += s.freedom;
            variance += s.variance * s.freedom;
            outline += block_at(place, b).outline;
            used += 1;
        }
        if (!(freedom > 4)) return result;
        variance = std::max(variance / freedom, 1e-4);
        normal /= variance;
        score /= variance;
        normal(2, 2) += 1 / (shape_.size_sd * shape_.size_sd);
        const Eigen::Matrix3d inverse = normal.inverse();
        const Eigen::Vector3d change = inverse * score;
        if (!change.allFinite()) return result;
        const Point found{x + offset.x + change[0], y + offset.y + change[1]};
        size = shape_.size + change[2];
        const bool settled = std::abs(change[0]) <= 0.75 / phases && std::abs(change[1]) <= 0.75 / phases;
        if (settled) {
            result.converged = true;
            result.outline = {found.x, found.y, size, shape_.blur};
            result.covariance = disagreement(place, change, variance) * inverse.topLeftCorner<2, 2>();
            result.contrast = contrast_;
            result.noise = std::sqrt(variance);
            result.coverage = outline;
            result.trimmed = 1 - used / std::max(looked, 1.0);
            return result;
        }
        const double far = std::hypot(change[0], change[1]);
        const double share = std::min(1.0, farthest_step / std::max(far, 1e-12));
        at = {x + offset.x + share * change[0], y + offset.y + share * change[1]};
        if (length(at - start) > farthest) return result;
    }
    return result;
}

}  // namespace shaker::tracking
