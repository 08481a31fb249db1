#include "tracking/patch_locator.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace shaker::tracking {
namespace {

constexpr double enough_match = 0.6;    // correlation; below it a position does not resemble the texture
constexpr double enough_coarse = 0.35;  // the same, of reduced pictures
constexpr int most_passes = 8;
constexpr double near_place = 0.75 / TextureBank::steps;  // px; the texture is straight so far from a place
constexpr double settled = 2e-3;                          // px, of a pass
constexpr double longest_step = 1.5, new_blocks_from = 0.5;  // px
constexpr int climbed_blocks = 16;                           // lead a climb
constexpr std::size_t tries_of_a_share = 2, tries_of_all = 24;

}  // namespace

bool PatchLocator::solve(const TextureBank::Sums& sums, Solution& s, double& offset,
                         Eigen::Vector2d& step) const {
    const Eigen::Matrix2d basis = sums.own.topLeftCorner<2, 2>();
    if (!(basis.determinant() > 1e-6 * basis(0, 0) * basis(1, 1))) return false;
    const Eigen::Matrix2d inverse = basis.inverse();
    const Eigen::Vector2d fitted = inverse * sums.picture.head<2>();
    offset = fitted[0];
    s.gain = fitted[1];
    if (!(s.gain > 0.05)) return false;
    // Score and slope from the smooth derivatives; gain and offset eliminated.
    const Eigen::Matrix2d across = sums.own.block<2, 2>(0, 2), seen = sums.own.block<2, 2>(4, 0);
    const Eigen::Vector2d score = sums.picture.segment<2>(2) - seen * fitted;
    const Eigen::Matrix2d slope = s.gain * (seen * inverse * across - sums.own.block<2, 2>(4, 2));
    const Eigen::Matrix2d spread = sums.own.bottomRightCorner<2, 2>() - seen * inverse * seen.transpose();
    if (one_direction_) {
        const double along = direction_.dot(slope * direction_);
        step = direction_ * direction_.dot(score) / along;
        s.covariance =
            direction_ * direction_.transpose() * direction_.dot(spread * direction_) / (along * along);
    } else {
        const Eigen::Matrix2d solved = slope.inverse();
        step = solved * score;
        s.covariance = solved * spread * solved.transpose();
    }
    if (!step.allFinite()) return false;
    const double n = basis(0, 0), total = sums.picture[4] - sums.picture[0] * sums.picture[0] / n;
    // The step from the place takes its share of the residuals.
    const Eigen::Matrix2d slopes = sums.own.block<2, 2>(2, 2) - across.transpose() * inverse * across;
    const double squares = sums.picture[4] - sums.picture.head<2>().dot(fitted) -
                           s.gain * s.gain * std::min(1.0, step.squaredNorm()) *
                               step.normalized().dot(slopes * step.normalized());
    s.variance = std::max(squares, 0.0) / std::max(n - 4, 1.0) + 1e-4;
    s.likeness = std::sqrt(std::clamp(1 - squares / total, 0.0, 1.0));
    return true;
}

PatchLocator::Solution PatchLocator::measure(const ImageView& image, Point start) {
    Solution s;
    s.shift = start;
    bank_.use_all();
    Point place{};
    for (int pass = 0; pass < most_passes; ++pass) {
        const Point off = s.shift - place;
        const bool stays = pass > 0 && std::max(std::abs(off.x), std::abs(off.y)) < near_place;
        if (!stays) {
            const auto nearest = TextureBank::nearest(s.shift);
            if (!bank_.compare(image, nearest)) return s;
            place = nearest.shift();
        }
        double offset = 0;
        Eigen::Vector2d step;
        if (!solve(bank_.sums(), s, offset, step)) return s;
        step *= std::min(1.0, longest_step / std::max(step.norm(), 1e-12));
        Point shift = place + Point{step[0], step[1]};
        if (one_direction_) {
            const Eigen::Vector2d moved{shift.x - start.x, shift.y - start.y};
            const Eigen::Vector2d along = direction_ * direction_.dot(moved);
            shift = start + Point{along[0], along[1]};
        }
        const double moved = length(shift - s.shift);
        s.shift = shift;
        s.converged = pass >= 2 && stays && moved < settled;
        if (s.converged) break;
        s.share = bank_.weigh(s.gain, offset);
        if (moved > new_blocks_from) bank_.use_all();
    }
    return s;
}

void PatchLocator::find_direction() {
    const Eigen::Matrix2d structure = bank_.sums().own.block<2, 2>(2, 2);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen{structure};
    one_direction_ = eigen.eigenvalues()[0] < 0.03 * eigen.eigenvalues()[1];
    direction_ = eigen.eigenvectors().col(1);
    const double along = std::abs(direction_[0] * subject_.along[0] + direction_[1] * subject_.along[1]);
    if (one_direction_ && along < 0.5) {
        throw InputError{subject_.label + ": the texture does not vary along the shaker's axis"};
    }
}

// Frame 0 fits itself without residual; its noise is measured with a mask that ignores planes and curvature.
void PatchLocator::find_noise(const ImageView& image) {
    const Box& b = bank_.texture().box();
    double sum = 0, n = 0;
    with_pixels(image, [&](auto p) {
        for (int y = b.y0 + 1; y + 1 < b.y1; ++y) {
            for (int x = b.x0 + 1; x + 1 < b.x1; ++x) {
                const double edges = p.at(x - 1, y) + p.at(x + 1, y) + p.at(x, y - 1) + p.at(x, y + 1);
                const double corners =
                    p.at(x - 1, y - 1) + p.at(x + 1, y - 1) + p.at(x - 1, y + 1) + p.at(x + 1, y + 1);
                sum += std::abs(corners - 2 * edges + 4 * p.at(x, y)) / 6;
                n += 1;
            }
        }
    });
    const double noise = sum / std::max(n, 1.0) * std::sqrt(std::numbers::pi / 2);
    least_variance_ = noise * noise + 1.0 / 12;
}

Point PatchLocator::learn(const ImageView& image) {
    const Box box = region_in(subject_, image);
    levels_in(subject_, image, box);
    bank_ = TextureBank{Texture{image, box}};
    search_ = TextureSearch{image, box};
    learned_ = {0.5 * (box.x0 + box.x1 - 1), 0.5 * (box.y0 + box.y1 - 1)};
    climbed_ = std::max(1, bank_.blocks() / climbed_blocks);
    bank_.learn(std::abs(subject_.along[0]) >= std::abs(subject_.along[1]) ? Axis::x : Axis::y);
    bank_.compare(image, {0, 0});
    bank_.use_all();
    find_direction();
    find_noise(image);
    return learned_;
}

double PatchLocator::extent() const noexcept {
    return 0.5 * std::min(bank_.texture().width(), bank_.texture().height());
}

bool PatchLocator::judge(const Solution& s, Candidate& out) const {
    if (!s.converged || s.gain < 0.3 || s.gain > 3 || s.share < 0.3 || s.likeness < enough_match)
        return false;
    const Eigen::Vector2d axis{subject_.along[0], subject_.along[1]};
    // The position of a texture with one direction is known along that direction, which may be oblique to the
    // axis.
    out.sd = std::sqrt(std::max(s.variance, least_variance_) *
                       (one_direction_ ? s.covariance.trace() : axis.dot(s.covariance * axis)));
    out.at = learned_ + s.shift;
    out.likeness = s.likeness * std::min(1.0, s.share);
    out.degraded = s.share < 0.8;
    return out.sd < 0.5;
}

void PatchLocator::try_peaks(const ImageView& image, const Box& shifts, std::size_t tries,
                             std::vector<Candidate>& out) {
    search_.scan(image, shifts, enough_coarse, peaks_);
    // A share tries the best peak, and the others in turn.
    tries = std::min(tries, peaks_.size());
    for (std::size_t i = 0; i < tries; ++i) {
        const std::size_t k = i == 0 || tries == peaks_.size() ? i : 1 + turn_++ % (peaks_.size() - 1);
        const Point start = bank_.climb(image, peaks_[k].shift, search_.cell() / 2, climbed_);
        Candidate candidate;
        if (!judge(measure(image, start), candidate)) continue;
        const auto same = [&](const Candidate& c) { return length(c.at - candidate.at) < extent(); };
        if (std::none_of(out.begin(), out.end(), same)) out.push_back(candidate);
    }
}

Box PatchLocator::around(Point shift) const noexcept {
    const int x = static_cast<int>(std::lround(shift.x)), y = static_cast<int>(std::lround(shift.y));
    const int r = static_cast<int>(reach());
    return {x - r, y - r, x + r + 1, y + r + 1};
}

bool PatchLocator::locate(const ImageView& image, Point predicted, Candidate& out) {
    const Point start = predicted - learned_;
    if (judge(measure(image, start), out) && length(out.at - predicted) < reach()) return true;
    near_.clear();
    try_peaks(image, around(start), 1, near_);
    if (near_.empty()) return false;
    out = near_.front();
    return length(out.at - predicted) < 1.5 * reach();
}

void PatchLocator::search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) {
    const Box& box = bank_.texture().box();
    const Box all{-box.x0, -box.y0, image.width - box.x1 + 1, image.height - box.y1 + 1};
    if (all.x1 <= all.x0 || all.y1 <= all.y0) return;
    const int tile = search_.tile();
    const int columns = (all.x1 - all.x0 + tile - 1) / tile, rows = (all.y1 - all.y0 + tile - 1) / tile;
    if (sweep == Sweep::share && columns * rows > 1) {
        try_peaks(image, around(last - learned_), 1, out);
        next_tile_ = (next_tile_ + 1) % (columns * rows);
        const int x = all.x0 + next_tile_ % columns * tile, y = all.y0 + next_tile_ / columns * tile;
        if (out.empty()) try_peaks(image, {x, y, x + tile, y + tile}, tries_of_a_share, out);
    } else {
        try_peaks(image, all, sweep == Sweep::share ? tries_of_a_share : tries_of_all, out);
    }
    std::ranges::stable_sort(out, std::ranges::greater{}, &Candidate::likeness);
}

}  // namespace shaker::tracking
