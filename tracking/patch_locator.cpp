// Locator for any texture: the region of frame 0, shifted until it fits.
#include <Eigen/Core>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tracking/image/pixels.hpp"
#include "tracking/image/region.hpp"
#include "tracking/image/texture_bank.hpp"
#include "tracking/locator.hpp"
#include "tracking/texture_search.hpp"

namespace shaker::tracking {

namespace {

/// Least squares of shift, gain and offset between raw pixels and the shifted texture T of frame 0: I(p) =
/// offset + gain T(p - shift). Blocks of 8 x 8 px that do not fit (hidden, reflecting) are excluded. A
/// texture that varies in one direction only is measured along it; the other coordinate stays at its value in
/// frame 0. A turn and a growth about the middle join the fit where they are sure.
class PatchLocator final : public Locator {
public:
    explicit PatchLocator(Subject subject) : subject_{std::move(subject)} {}
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 8; }
    [[nodiscard]] double extent() const noexcept override;
    [[nodiscard]] bool interchangeable() const noexcept override { return true; }

private:
    struct Solution {
        Point shift;
        double gain = 0, variance = 0, likeness = 0, share = 0;
        Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // divided by the variance
        bool converged = false;
        double turned =
            0;  // rms of what the parts move beside the shift by a turn and growth that are sure, px
    };
    /// Finds gain, offset and step from the sums at one place. Returns false when these do not determine
    /// them.
    bool solve(const TextureBank::Sums& sums, Solution& s, double& offset, Eigen::Vector2d& step) const;
    Solution measure(const ImageView& image, Point start);
    /// Where the newest comparison, at a place, shows for sure that the body turns or grows: measures the
    /// shift of its middle beside these. way(p): see TextureBank::motion(); the first `shifts` columns are
    /// shifts.
    template <int ways, int shifts, class Way>
    void separate(Solution& s, Point place, Way way) const;
    void separate_turn(Solution& s, Point place) const;
    void find_direction();
    /// Noise of the pixels where the texture is after a shift, codes^2.
    [[nodiscard]] double noise_variance(const ImageView& image, Point shift) const;
    /// rms of what its parts have moved beside the shift, px: the body turns, bends or comes nearer.
    [[nodiscard]] double distortion_px(const ImageView& image, const Solution& solution) const;
    bool judge(const ImageView& image, const Solution& solution, Candidate& out) const;
    /// Appends what resembles the texture at shifts in a box; tries at most so many places.
    void try_peaks(const ImageView& image, const Box& shifts, std::size_t tries, std::vector<Candidate>& out);
    [[nodiscard]] Box around(Point shift) const noexcept;

    Subject subject_;
    TextureBank bank_;
    TextureSearch search_;
    std::vector<TexturePeak> peaks_;
    std::vector<Candidate> near_;
    Point learned_;
    int climbed_ = 1;  // one block of so many leads a climb
    bool one_direction_ = false;
    double least_variance_ = 0;  // of the noise, from frame 0 alone
    double steepness2_ = 0;      // mean square of the texture's gradient, codes^2/px^2
    Eigen::Vector2d direction_{1, 0};
    // Progress of a search that takes several pictures.
    std::size_t turn_ = 0;
    int next_tile_ = 0;
};

constexpr double enough_match = 0.6;    // correlation; below it a position does not resemble the texture
constexpr double enough_coarse = 0.35;  // the same, of reduced pictures
constexpr int most_passes = 8;
constexpr double near_place = 0.75 / TextureBank::steps;  // px; the texture is straight so far from a place
constexpr double settled = 2e-3;                          // px, of a pass
constexpr double longest_step = 1.5, new_blocks_from = 0.5;  // px
constexpr int climbed_blocks = 16;                           // lead a climb
constexpr std::size_t tries_of_a_share = 2, tries_of_all = 24;

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
        if (s.converged) {
            separate_turn(s, place);
            break;
        }
        s.share = bank_.weigh(s.gain, offset);
        if (moved > new_blocks_from) bank_.use_all();
    }
    return s;
}

template <int ways, int shifts, class Way>
void PatchLocator::separate(Solution& s, Point place, Way way) const {
    constexpr double sure = 25;  // chi squared
    constexpr int others = ways - shifts;
    const auto motion = bank_.motion<ways>(way);
    const TextureBank::Sums sums = bank_.sums();
    const Eigen::Matrix2d inverse = sums.own.topLeftCorner<2, 2>().inverse();
    const Eigen::Matrix<double, ways, 1> score =
        motion.picture - motion.seen * inverse * sums.picture.head<2>();
    const Eigen::Matrix<double, ways, ways> solved =
        (s.gain * (motion.seen * inverse * motion.across - motion.own)).inverse();
    const Eigen::Matrix<double, ways, ways> covariance =
        solved * (motion.spread - motion.seen * inverse * motion.seen.transpose()) * solved.transpose();
    const Eigen::Matrix<double, ways, 1> step = solved * score;
    const Eigen::Matrix<double, others, 1> beside = step.template tail<others>();
    const double variance = std::max(s.variance, least_variance_);
    const double squares =
        beside.dot(covariance.template bottomRightCorner<others, others>().inverse() * beside);
    if (!step.allFinite() || !(squares > sure * variance)) return;
    const Eigen::Matrix<double, 2, shifts> along = way(Point{}).template leftCols<shifts>();
    const Eigen::Vector2d off{place.x - s.shift.x, place.y - s.shift.y};
    const Eigen::Vector2d moved = along * (step.template head<shifts>() + along.transpose() * off);
    s.shift = s.shift + Point{moved[0], moved[1]};
    s.covariance = along * covariance.template topLeftCorner<shifts, shifts>() * along.transpose();
    s.turned = beside.norm() * std::hypot(bank_.texture().width(), bank_.texture().height()) / std::sqrt(12);
}

// Turn and growth; a texture with one direction shows the parts of these along it.
void PatchLocator::separate_turn(Solution& s, Point place) const {
    if (one_direction_) {
        separate<3, 1>(s, place, [this](Point p) -> Eigen::Matrix<double, 2, 3> {
            return direction_ * Eigen::RowVector3d{1, p.x, p.y};
        });
    } else {
        separate<4, 2>(s, place, [](Point p) {
            return Eigen::Matrix<double, 2, 4>{{1, 0, -p.y, p.x}, {0, 1, p.x, p.y}};
        });
    }
}

void PatchLocator::find_direction() {
    // Noise varies in all directions, but hardly after smoothing.
    const Eigen::Matrix2d structure = bank_.sums().own.bottomRightCorner<2, 2>();
    steepness2_ = bank_.sums().own.block<2, 2>(2, 2).trace() / bank_.sums().own(0, 0);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen{structure};
    one_direction_ = eigen.eigenvalues()[0] < 0.03 * eigen.eigenvalues()[1];
    direction_ = eigen.eigenvectors().col(1);
    const double along = std::abs(direction_[0] * subject_.along[0] + direction_[1] * subject_.along[1]);
    if (one_direction_ && along < 0.5) {
        throw InputError{subject_.label + ": the texture does not vary along the shaker's axis"};
    }
}

// By a mask that ignores planes and curvature: frame 0 fits itself without residual.
double PatchLocator::noise_variance(const ImageView& image, Point shift) const {
    Box b = bank_.texture().box();
    const int dx = static_cast<int>(std::lround(shift.x)), dy = static_cast<int>(std::lround(shift.y));
    b = {std::max(b.x0 + dx, 0), std::max(b.y0 + dy, 0), std::min(b.x1 + dx, image.width),
         std::min(b.y1 + dy, image.height)};
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
    return noise * noise + 1.0 / 12;
}

double PatchLocator::distortion_px(const ImageView& image, const Solution& s) const {
    constexpr double worth_a_look = 1.2, sure = 1.1;  // times the noise of this frame and of frame 0
    const double learned = s.gain * s.gain * least_variance_;
    if (s.variance < worth_a_look * (least_variance_ + learned)) return 0;
    const double noise = std::max(least_variance_, noise_variance(image, s.shift)) + learned;
    if (s.variance < sure * noise) return 0;
    const double directions = one_direction_ ? 1 : 2;
    return std::sqrt(directions * (s.variance - noise) / (s.gain * s.gain * steepness2_));
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
    least_variance_ = noise_variance(image, {});
    return learned_;
}

double PatchLocator::extent() const noexcept {
    return 0.5 * std::min(bank_.texture().width(), bank_.texture().height());
}

bool PatchLocator::judge(const ImageView& image, const Solution& s, Candidate& out) const {
    constexpr double distorted_from = 0.4;  // px
    constexpr double moves_middle =
        0.3;  // of a distortion: a body that turns about a point 0.5 to 2 sizes off
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
    out.doubt = 0;
    if (!(out.sd < 0.5)) return false;
    const double distortion = std::max(s.turned, distortion_px(image, s));
    // What bars that turn move along themselves is not seen.
    if (distortion > (one_direction_ && s.turned > 0 ? 0 : distorted_from)) {
        out.degraded = true;
        out.doubt = moves_middle * distortion;
    }
    return true;
}

void PatchLocator::try_peaks(const ImageView& image, const Box& shifts, std::size_t tries,
                             std::vector<Candidate>& out) {
    search_.scan(image, shifts, enough_coarse, peaks_);
    // A share tries the best peak, and the others in turn.
    tries = std::min(tries, peaks_.size());
    for (std::size_t i = 0; i < tries; ++i) {
        const std::size_t k = i == 0 || tries == peaks_.size() ? i : 1 + turn_++ % (peaks_.size() - 1);
        Point start = bank_.climb(image, peaks_[k].shift, search_.cell() / 2, climbed_);
        if (one_direction_) {
            const double along = direction_[0] * start.x + direction_[1] * start.y;
            start = {direction_[0] * along, direction_[1] * along};
        }
        Candidate candidate;
        if (!judge(image, measure(image, start), candidate)) continue;
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
    if (judge(image, measure(image, start), out) && length(out.at - predicted) < reach()) return true;
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

}  // namespace

std::unique_ptr<Locator> make_patch_locator(Subject subject) {
    return std::make_unique<PatchLocator>(std::move(subject));
}

}  // namespace shaker::tracking
