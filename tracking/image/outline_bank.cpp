#include "tracking/image/outline_bank.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace shaker::tracking {
namespace {

constexpr double least_variance = 1e-4;
constexpr double farthest_step = 1.5;  // px
constexpr double farthest = 3;         // px from the start
constexpr std::size_t few_of = 4;      // one block of so many leads a first step
constexpr std::size_t many = 16;       // blocks, that it takes

using Lanes [[gnu::vector_size(16)]] = float;

using Wide [[gnu::vector_size(32)]] = double;  // sums of whole grey levels are exact

template <class T>
T load(const auto* from) noexcept {
    T all;
    std::memcpy(&all, from, sizeof all);
    return all;
}

double total(const auto& lanes) noexcept {
    return (static_cast<double>(lanes[0]) + static_cast<double>(lanes[1])) +
           (static_cast<double>(lanes[2]) + static_cast<double>(lanes[3]));
}

// Grey levels above `level`. Returns the end of what was written.
template <class T>
float* copy(const T* from, int count, float level, float* to) noexcept {
    using Four [[gnu::vector_size(4 * sizeof(T))]] = T;
    int i = 0;
    for (; i + 4 <= count; i += 4) {
        const Lanes values = __builtin_convertvector(load<Four>(from + i), Lanes) - level;
        std::memcpy(to + i, &values, sizeof values);
    }
    for (; i < count; ++i) to[i] = static_cast<float>(from[i]) - level;
    return to + count;
}

}  // namespace

template <class T>
void OutlineBank::look(const Pixels<T>& pixels, std::size_t place, int x, int y, Box whole, bool thinned) {
    for (std::size_t b = 0; b < ranges_.size(); ++b) {
        const Range& range = ranges_[b];
        seen_[b].used = false;
        const bool in_view = range.end > 0 && x + range.x0 >= whole.x0 && x + range.x1 < whole.x1 &&
                             y + range.y0 >= whole.y0 && y + range.y1 < whole.y1;
        if (!in_view || (thinned && b % few_of != 0)) continue;
        if (plane() && !(b < slopes_.size() && slopes_[b].frames >= KnownSlope::most_frames)) continue;
        learn(place, b);
        if (block_at(place, b).normal(2, 2) == 0) continue;
        float* to = values_.data();
        for (int k = range.first_run; k < range.last_run; ++k) {
            const Run& run = runs_[static_cast<std::size_t>(k)];
            to = copy(pixels.row(y + run.y) + (x + run.x), run.length, level_, to);
        }
        std::fill(to, values_.data() + range.padded, 0.0f);
        plane() ? see<false>(b, place) : see<true>(b, place);
    }
}

// What the values of a block show: its gain, its residual and its score for the outline.
template <bool flat>
void OutlineBank::see(std::size_t b, std::size_t place) {
    const Range& range = ranges_[b];
    const Block& block = block_at(place, b);
    const float* const weights = weights_of(place, b);
    std::array<Lanes, 4> weighted{};
    Lanes along{}, across{};
    Wide sum{}, squares{};
    for (int i = 0; i < range.padded; i += lanes) {
        const Lanes value = load<Lanes>(&values_[static_cast<std::size_t>(i)]);
        const Wide exact = __builtin_convertvector(value, Wide);
        for (int k = flat ? 1 : 0; k < (flat ? 3 : 4); ++k)
            weighted[static_cast<std::size_t>(k)] += value * load<Lanes>(weights + k * range.padded + i);
        if constexpr (flat) {
            const Wide faded = exact * __builtin_convertvector(load<Lanes>(weights + i), Wide);
            sum += faded;
            squares += faded * exact;
        } else {
            sum += exact;
            squares += exact * exact;
            along += value * load<Lanes>(&along_[static_cast<std::size_t>(range.first + i)]);
            across += value * load<Lanes>(&across_[static_cast<std::size_t>(range.first + i)]);
        }
    }
    Eigen::Vector4d sums{total(sum), total(weighted[flat ? 1 : 0]), total(along), total(across)};
    Seen& seen = seen_[b];
    seen.freedom = block.weight - (flat ? 2 : 4);
    double known = 0;  // squares of the known slope
    if constexpr (flat) {
        seen.score = block.lead * total(weighted[2]);
    } else {
        seen.score = {total(weighted[1]), total(weighted[2]), total(weighted[3])};
        const double contrast = (block.ground * sums)[1];  // hardly depends on the slopes
        for (int i = 0; i < 2; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const double certainty = KnownSlope::most_frames * block.squares.at(k),
                         s = contrast * slopes_[b].slope.at(k);
            sums[2 + i] += certainty * s;
            known += certainty * s * s;
            seen.score -= s * block.by_slope.row(i).transpose();
        }
    }
    const Eigen::Vector4d ground = block.ground * sums;
    seen.gain = ground[1];
    seen.slope = {ground[2] / seen.gain, ground[3] / seen.gain};
    seen.variance = std::max(total(squares) + known - sums.dot(ground), 0.0) / seen.freedom;
    seen.score *= seen.gain;
    seen.used = true;
}

// The slope of the ground of a block that this picture shows by itself, with the outline at its place.
std::array<double, 2> OutlineBank::own_slope(std::size_t b, std::size_t place,
                                             const Eigen::Vector3d& change) const {
    const Block& block = block_at(place, b);
    const Seen& seen = seen_[b];
    std::array<double, 2> own{};
    for (int i = 0; i < 2; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double per_slope = KnownSlope::most_frames * block.squares.at(k),
                     known = slopes_[b].slope.at(k);
        const double with_known = seen.slope.at(k) - block.by_slope.row(i).dot(change) / per_slope;
        own.at(k) = known + (1 + KnownSlope::most_frames) * (with_known - known);
    }
    return own;
}

// The slopes of all blocks that are used; true when one differs from what is known.
bool OutlineBank::tilted(std::size_t place, const Eigen::Vector3d& change) {
    bool differs = false;
    for (std::size_t b = 0; b < seen_.size(); ++b) {
        Seen& s = seen_[b];
        if (!s.used) continue;
        s.slope = own_slope(b, place, change);
        differs = differs ||
                  slopes_[b].differs(s.slope, s.variance / (s.gain * s.gain), block_at(place, b).squares);
    }
    return differs;
}

// Squares of grey levels of a block on flat ground that a change of the outline explains.
double OutlineBank::explained_by(const Eigen::Vector3d& change, std::size_t place, std::size_t b) const {
    const Seen& s = seen_[b];
    const Block& block = block_at(place, b);
    return block.share * change.dot(2 * s.score - s.gain * s.gain * block.normal * change);
}

double OutlineBank::median_of(double Seen::*member) {
    sorted_.clear();
    for (std::size_t b = 0; b < seen_.size(); ++b)
        if (seen_[b].used && !is_mean(b)) sorted_.push_back(seen_[b].*member);
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
        s.used = s.used && !s.habit.strange(s.gain / contrast_) && s.variance <= 16 * variance + 1e-9;
    }
}

// The square of a block's distance from the common outline and its habit, in its own errors. Sets Seen::off.
double OutlineBank::stranger(std::size_t b, std::size_t place, const Eigen::Vector3d& change,
                             double variance) {
    Seen& s = seen_[b];
    const Eigen::Matrix3d normal = s.gain * s.gain * block_at(place, b).normal;
    s.off = (s.score - normal * change)[2] / normal(2, 2);
    const double off = s.off - s.habit.off;
    return off * off * normal(2, 2) / (variance * s.habit.known());
}

// Blocks whose outline lies elsewhere, as beside a card that ends at it, are no longer used. True when there
// are some, among many.
bool OutlineBank::exclude_strangers(std::size_t place, const Step& step) {
    constexpr double errors = 5, least_px = 0.1, fewest = 7;
    const double variance = std::max(step.squares / step.freedom, least_variance);
    bool any = false;
    for (std::size_t b = 0; b < seen_.size(); ++b) {
        Seen& s = seen_[b];
        if (!s.used || is_mean(b) || step.used < fewest) continue;
        const double far = stranger(b, place, step.change, variance);
        if (far < errors * errors || std::abs(s.off - s.habit.off) < least_px) continue;
        s.used = false;
        any = true;
    }
    return any;
}

// How far blocks disagree beyond their noise and learned offsets: a factor of the variance, at least 1.
double OutlineBank::disagreement(std::size_t place, const Eigen::Vector3d& change, double variance) {
    double squares = 0, count = 0;
    for (std::size_t b = 0; b < seen_.size(); ++b) {
        Seen& s = seen_[b];
        if (!s.used || is_mean(b)) continue;
        squares += stranger(b, place, change, variance);
        count += 1;
    }
    return count > 6 ? std::max(1.0, squares / (count - 4)) : 1;
}

// What the means show, over independent noise. variance: of the other blocks' grey levels, with the outline
// at its place. 0: not known.
double OutlineBank::common_of(const Eigen::Vector3d& change, std::size_t place, double variance) const {
    double squares = 0, freedom = 0;
    for (std::size_t b = seen_.size() - static_cast<std::size_t>(shape_.means); b < seen_.size(); ++b) {
        if (!seen_[b].used) continue;
        squares += seen_[b].variance * seen_[b].freedom - explained_by(change, place, b);
        freedom += seen_[b].freedom;
    }
    if (!(freedom > 0)) return 0;
    const double blocks_a_mean = static_cast<double>(seen_.size()) / shape_.means - 1;
    return blocks_a_mean * std::clamp(squares / (freedom * variance), 0.0, 1.0);
}

void OutlineBank::accept(std::span<KnownSlope> slopes) {
    for (std::size_t b = 0; b < seen_.size(); ++b) {
        Seen& s = seen_[b];
        if (!s.used) {
            s.habit.pass_over();
            continue;
        }
        if (plane()) slopes[b].learn(s.slope);
        s.habit.learn(s.off, s.gain / contrast_);
    }
    if (newest_common_ > 0) {
        common_frames_ = std::min(common_frames_ + 1, BlockHabit::longest_memory);
        common_ += (std::exchange(newest_common_, 0) - common_) / common_frames_;
    }
    learn_ahead();
}

// Information with the prior of the size, and, for straight edges, of the place along them.
Eigen::Matrix3d OutlineBank::certain(const Eigen::Matrix3d& normal, double variance) const {
    Eigen::Matrix3d all = normal / variance;
    all(2, 2) += 1 / (shape_.size_sd * shape_.size_sd);
    if (shape_.straight) all(1, 1) += 1;
    return all;
}

OutlineBank::Step OutlineBank::step_at(const ImageView& image, std::size_t place, int x, int y,
                                       bool thinned) {
    const auto look_at = [&](auto pixels) { look(pixels, place, x, y, whole(image), thinned); };
    image.bytes_per_pixel == 4 ? look_at(Pixels<float>{image}) : with_pixels(image, look_at);
    const double looked = static_cast<double>(std::ranges::count_if(seen_, &Seen::used)) - shape_.means;
    choose_blocks();
    return sums_at(place, looked);
}

OutlineBank::Step OutlineBank::sums_at(std::size_t place, double looked) const {
    Step step;
    step.looked = looked;
    for (std::size_t b = 0; b < seen_.size(); ++b) {
        const Seen& s = seen_[b];
        if (!s.used || is_mean(b)) continue;
        step.normal += s.gain * s.gain * block_at(place, b).normal;
        step.score += s.score;
        step.freedom += s.freedom;
        step.squares += s.variance * s.freedom;
        step.outline += block_at(place, b).outline;
        step.used += 1;
    }
    const double variance = std::max(step.squares / std::max(step.freedom, 1.0), least_variance);
    step.change = certain(step.normal, variance).inverse() * step.score / variance;
    return step;
}

EdgeFitResult OutlineBank::fit(const ImageView& image, Point start, std::span<const KnownSlope> slopes) {
    slopes_ = slopes;
    Point at = start;
    for (int count = 0; count < most_steps; ++count) {
        const int x = x_ = static_cast<int>(std::floor(at.x + 0.5)),
                  y = y_ = static_cast<int>(std::floor(at.y + 0.5));
        const auto phase = [](double off) {
            return std::clamp(static_cast<int>((off + 0.5) * phases), 0, phases - 1);
        };
        const std::size_t place = place_ =
            static_cast<std::size_t>(phase(at.y - y) * phases + phase(at.x - x));
        const Point offset = offset_at(place);
        const bool thinned = count == 0 && ranges_.size() - static_cast<std::size_t>(shape_.means) >= many;
        Step step = step_at(image, place, x, y, thinned);
        if (!(step.freedom > 4)) {
            if (thinned) continue;
            return {};
        }
        if (!step.change.allFinite()) return {};
        Eigen::Vector2d change = step.change.head<2>() / response_;
        if (!thinned && change.cwiseAbs().maxCoeff() <= 0.75 / phases) {
            if (plane() && tilted(place, step.change)) return {};
            if (exclude_strangers(place, step)) step = sums_at(place, step.looked);
            if (!(step.freedom > 4 && step.change.allFinite())) return {};
            change_ = step.change;
            change = change_.head<2>() / response_;
            EdgeFitResult result = summed(step);
            result.outline = {x + offset.x + change[0], shape_.straight ? start.y : y + offset.y + change[1],
                              shape_.size + change_[2], shape_.blur};
            return result;
        }
        const double far = change.norm();
        const double share = std::min(1.0, farthest_step / std::max(far, 1e-12));
        at = {x + offset.x + share * change[0], shape_.straight ? start.y : y + offset.y + share * change[1]};
        if (length(at - start) > farthest) return {};
    }
    return {};
}

// What the last step shows besides the place.
EdgeFitResult OutlineBank::summed(const Step& step) {
    double squares = step.squares;
    EdgeFitResult result;
    // What the place on the grid leaves is no noise. With known slopes it stands for their error.
    for (std::size_t b = 0; b < seen_.size(); ++b) {
        if (!seen_[b].used || is_mean(b)) continue;
        if (!plane()) squares -= explained_by(step.change, place_, b);
        for (std::size_t i = 0; i < 2 && plane(); ++i) result.slope.at(i) += seen_[b].slope.at(i) / step.used;
    }
    const double variance = std::max(squares / step.freedom, least_variance);
    // Not where something is in front of a block, which is in the mean, too.
    whole_ = step.used == step.looked;
    newest_common_ = whole_ ? common_of(step.change, place_, variance) : 0;
    result.converged = true;
    result.covariance = common() * disagreement(place_, step.change, variance) *
                        certain(step.normal, variance).inverse().topLeftCorner<2, 2>() /
                        (response_ * response_);
    result.contrast = contrast_;
    result.freedom = step.freedom;
    result.noise = std::sqrt(variance);
    result.coverage = step.outline;
    result.trimmed = 1 - step.used / std::max(step.looked, 1.0);
    return result;
}

void OutlineBank::learn_response(const ImageView& image, std::span<const KnownSlope> slopes) {
    constexpr double least = 0.7, most = 1.4;
    const std::size_t beside = place_ % phases + 1 < phases ? place_ + 1 : place_ - 1;
    for (std::size_t b = 0; b < ranges_.size(); ++b)
        if (!whole_ || !block_at(beside, b).known) return;  // weights are computed elsewhere
    slopes_ = slopes;
    const double apart = offset_at(beside).x - offset_at(place_).x;
    const Step step = step_at(image, beside, x_, y_, false);
    const double response = (change_[0] - step.change[0]) / apart;
    if (!(step.used == step.looked && response > least && response < most)) return;
    response_frames_ = std::min(response_frames_ + 1, BlockHabit::longest_memory);
    response_ += (response - response_) / response_frames_;
}

}  // namespace shaker::tracking
