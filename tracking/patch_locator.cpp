// Locator for any texture: the region of frame 0, shifted until it fits.
#include <Eigen/Core>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tracking/image/pixels.hpp"
#include "tracking/image/region.hpp"
#include "tracking/image/texture_bank.hpp"
#include "tracking/locator.hpp"

namespace shaker::tracking {

namespace {

/// Possible shift of a texture, to about half a cell. score: correlation, 1 at most.
struct TexturePeak {
    Point shift;
    double score = 0;
};

/// Pixels of the reduced pictures are means of cells, as large as the texture's detail allows.
class TextureSearch {
public:
    TextureSearch() = default;
    /// The texture in a box of frame 0.
    TextureSearch(const ImageView& image, const Box& box);
    /// Replaces `out` by the local maxima of at least `least`, best first, at most 24, for shifts in a box; a
    /// texture that would not be whole in the picture is not looked for.
    void scan(const ImageView& image, const Box& shifts, double least, std::vector<TexturePeak>& out) const;
    /// px, side of a cell.
    [[nodiscard]] int cell() const noexcept { return cell_; }
    /// px, side of a box of shifts that scan() covers in about 0.1 ms.
    [[nodiscard]] int tile() const noexcept;

private:
    Box box_;  // of the texture that is compared, in frame 0
    int cell_ = 1;
    cv::Mat1f texture_;  // reduced
};

/// Least squares of shift, gain and offset between raw pixels and the shifted texture T of frame 0: I(p) =
/// offset + gain T(p - shift). Blocks of 8 x 8 px that do not fit (hidden, reflecting) are excluded. A
/// texture that varies in one direction only is measured along it; the other coordinate stays at its value in
/// frame 0.
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
    };
    /// Finds gain, offset and step from the sums at one place. Returns false when these do not determine
    /// them.
    bool solve(const TextureBank::Sums& sums, Solution& s, double& offset, Eigen::Vector2d& step) const;
    Solution measure(const ImageView& image, Point start);
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

constexpr int largest_cell = 16, fewest_cells = 8;  // fewest_cells: along the shorter side
constexpr double detail_kept = 0.6;                 // of the contrast, from one size of cell to twice that
constexpr double most_cells = 600;                  // of the texture; a larger one is compared in its middle
constexpr std::size_t most_peaks = 24;
constexpr double cells_at_a_time = 4500;  // of the picture, about 0.1 ms

// Means of the cells of a box whose sides are multiples of a cell.
cv::Mat1f reduced(const ImageView& image, const Box& box, int cell) {
    const cv::Mat whole_image{image.height, image.width, image.bytes_per_pixel == 2 ? CV_16UC1 : CV_8UC1,
                              const_cast<std::byte*>(image.pixels), static_cast<std::size_t>(image.stride)};
    const cv::Mat part = whole_image(cv::Rect{box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0});
    cv::Mat small;
    cv::resize(part, small, {part.cols / cell, part.rows / cell}, 0, 0, cv::INTER_AREA);
    cv::Mat1f out;
    small.convertTo(out, CV_32F);
    return out;
}

// The middle of a range, of a length that is a multiple of a cell.
void trim(int& first, int& last, int cell, int most) {
    const int length = std::min((last - first) / cell, most) * cell;
    first += (last - first - length) / 2;
    last = first + length;
}

double contrast_of(const cv::Mat1f& levels) {
    cv::Scalar mean, sd;
    cv::meanStdDev(levels, mean, sd);
    return sd[0];
}

constexpr double enough_match = 0.6;    // correlation; below it a position does not resemble the texture
constexpr double enough_coarse = 0.35;  // the same, of reduced pictures
constexpr int most_passes = 8;
constexpr double near_place = 0.75 / TextureBank::steps;  // px; the texture is straight so far from a place
constexpr double settled = 2e-3;                          // px, of a pass
constexpr double longest_step = 1.5, new_blocks_from = 0.5;  // px
constexpr int climbed_blocks = 16;                           // lead a climb
constexpr std::size_t tries_of_a_share = 2, tries_of_all = 24;

TextureSearch::TextureSearch(const ImageView& image, const Box& box) {
    for (int cell = 1; cell <= largest_cell; cell *= 2) {
        Box part = box;
        const double width = part.x1 - part.x0, height = part.y1 - part.y0;
        const double too_large = std::sqrt(std::max(1.0, width * height / (cell * cell * most_cells)));
        const auto most = [&](double side) {
            return std::max(fewest_cells, static_cast<int>(side / cell / too_large));
        };
        trim(part.x0, part.x1, cell, most(width));
        trim(part.y0, part.y1, cell, most(height));
        if (cell > 1 && std::min(part.x1 - part.x0, part.y1 - part.y0) < fewest_cells * cell) return;
        cv::Mat1f texture = reduced(image, part, cell);
        if (cell > 1 && contrast_of(texture) < detail_kept * contrast_of(texture_)) return;
        texture_ = std::move(texture);
        box_ = part;
        cell_ = cell;
    }
}

// A tile of t cells reads (t + columns) (t + rows) cells of the picture.
int TextureSearch::tile() const noexcept {
    const double columns = texture_.cols, rows = texture_.rows, off = columns - rows;
    return std::max(
               4, static_cast<int>(std::sqrt(cells_at_a_time + 0.25 * off * off) - 0.5 * (columns + rows))) *
           cell_;
}

void TextureSearch::scan(const ImageView& image, const Box& shifts, double least,
                         std::vector<TexturePeak>& out) const {
    out.clear();
    Box area{std::max(0, box_.x0 + shifts.x0), std::max(0, box_.y0 + shifts.y0),
             std::min(image.width, box_.x1 + shifts.x1), std::min(image.height, box_.y1 + shifts.y1)};
    area.x1 = area.x0 + (area.x1 - area.x0) / cell_ * cell_;
    area.y1 = area.y0 + (area.y1 - area.y0) / cell_ * cell_;
    if (area.x1 - area.x0 < texture_.cols * cell_ || area.y1 - area.y0 < texture_.rows * cell_) return;
    cv::Mat1f score;
    cv::matchTemplate(reduced(image, area, cell_), texture_, score, cv::TM_CCOEFF_NORMED);
    while (out.size() < most_peaks) {
        double best = 0;
        cv::Point at;
        cv::minMaxLoc(score, nullptr, &best, nullptr, &at);
        if (!(best > least)) break;
        out.push_back(
            {{1.0 * area.x0 + at.x * cell_ - box_.x0, 1.0 * area.y0 + at.y * cell_ - box_.y0}, best});
        const int r = std::max(1, std::min(texture_.cols, texture_.rows) / 2);
        score(cv::Rect{at.x - r, at.y - r, 2 * r + 1, 2 * r + 1} & cv::Rect{0, 0, score.cols, score.rows})
            .setTo(0);
    }
}

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
    steepness2_ = structure.trace() / bank_.sums().own(0, 0);
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
    const double distortion = distortion_px(image, s);
    if (distortion > distorted_from) {
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
        const Point start = bank_.climb(image, peaks_[k].shift, search_.cell() / 2, climbed_);
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
