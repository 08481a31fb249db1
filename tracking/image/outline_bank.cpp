#include "tracking/image/outline_bank.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "tracking/image/edge_profile.hpp"

namespace shaker::tracking {
namespace {

constexpr double least_spread = 0.02;  // of E within a block, as in EdgeFit
constexpr double least_variance = 1e-4;
constexpr double farthest_step = 1.5;  // px
constexpr double farthest = 3;         // px from the start
constexpr std::size_t few_of = 4;      // one block of so many leads a first step
constexpr std::size_t many = 16;       // blocks, that it takes
constexpr int sites_ahead = 500;  // at least, whose weights are computed in a picture before they are needed

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

void OutlineBank::shape(const Shape& shape, std::vector<Site> sites, const std::vector<Point>& shifts) {
    shape_ = shape;
    sites_ = std::move(sites);
    runs_.clear();
    ranges_.assign(shifts.size(), {});
    for (std::size_t b = 0; b < shifts.size(); ++b) ranges_[b].shift = shifts[b];
    for (std::size_t i = 0; i < sites_.size(); ++i) {
        const Site& s = sites_[i];
        Range& r = ranges_[static_cast<std::size_t>(s.block)];
        if (r.end == 0) {
            r.begin = static_cast<int>(i);
            r.first_run = r.last_run = static_cast<int>(runs_.size());
            r.x0 = r.x1 = s.x;
            r.y0 = r.y1 = s.y;
        }
        const Site* const before = r.end == 0 ? nullptr : &sites_[i - 1];
        if (before == nullptr || before->y != s.y || before->x + 1 != s.x) {
            runs_.push_back({s.x, s.y, 0});
            ++r.last_run;
        }
        ++runs_.back().length;
        r.end = static_cast<int>(i) + 1;
        r.x0 = std::min(r.x0, s.x);
        r.x1 = std::max(r.x1, s.x);
        r.y0 = std::min(r.y0, s.y);
        r.y1 = std::max(r.y1, s.y);
    }
    int longest = 0;
    weights_a_place_ = 0;
    for (Range& r : ranges_) {
        r.padded = (r.end - r.begin + lanes - 1) / lanes * lanes;
        r.weights = static_cast<int>(weights_a_place_);
        weights_a_place_ += static_cast<std::size_t>(4 * r.padded);
        longest = std::max(longest, r.padded);
    }
    blocks_.assign(phases * phases * ranges_.size(), {});
    ahead_ = 0;
    weights_ = std::make_unique_for_overwrite<float[]>(phases * phases * weights_a_place_);
    values_.assign(static_cast<std::size_t>(longest), 0);
    level_ = static_cast<float>(std::lround(shape_.level));
    along_.assign(weights_a_place_ / 4, 0);
    across_.assign(weights_a_place_ / 4, 0);
    for (const Range& r : ranges_) {
        for (int i = r.begin; i < r.end; ++i) {
            const auto at = static_cast<std::size_t>(r.weights / 4 + i - r.begin);
            along_[at] = static_cast<float>(sites_[static_cast<std::size_t>(i)].x - r.shift.x);
            across_[at] = static_cast<float>(sites_[static_cast<std::size_t>(i)].y - r.shift.y);
        }
    }
    seen_.assign(ranges_.size(), {});
    sorted_.reserve(ranges_.size());
    columns_.setOnes(longest, 7);
}

void OutlineBank::resize(double size, double blur) noexcept {
    shape_.size = size;
    shape_.blur = blur;
    for (Block& b : blocks_) b.known = false;
    ahead_ = 0;
}

Point OutlineBank::offset_at(std::size_t place) noexcept {
    return {(static_cast<double>(place % phases) + 0.5) / phases - 0.5,
            (static_cast<double>(place / phases) + 0.5) / phases - 0.5};
}

bool OutlineBank::learn(std::size_t place, std::size_t b) {
    if (block_at(place, b).known) return false;
    plane() ? learn<4>(place, b) : learn<2>(place, b);
    return true;
}

template <int nuisances>
void OutlineBank::learn(std::size_t place, std::size_t b) {
    const Point offset = offset_at(place);
    const Range& range = ranges_[b];
    const Eigen::Index count = range.end - range.begin;
    Block& block = blocks_[place * ranges_.size() + b];
    block.known = true;
    block.normal.setZero();
    const double px = range.shift.x + offset.x, py = range.shift.y + offset.y;
    for (Eigen::Index i = 0; i < count; ++i) {
        const Site& s = sites_[static_cast<std::size_t>(range.begin + i)];
        const double du = s.x - px, dv = shape_.straight ? 0 : s.y - py, r = std::sqrt(du * du + dv * dv);
        const auto [e, g, by_blur] = shape_.straight ? EdgeProfile::upright(shape_.size - r, shape_.blur)
                                                     : EdgeProfile::round(shape_.size - r, shape_.blur);
        const double per_r = r > 1e-9 ? g / r : 0;
        columns_(i, 1) = e;
        columns_(i, 2) = s.x - range.shift.x;  // a slope turns about the block
        columns_(i, 3) = s.y - range.shift.y;
        columns_(i, 4) = du * per_r;
        columns_(i, 5) = dv * per_r;
        columns_(i, 6) = g;
    }
    // lazyProduct() allocates nothing.
    const auto unknown = columns_.topRows(count).leftCols<nuisances>();
    const auto outline = columns_.topRows(count).middleCols<3>(4);
    using Ground = Eigen::Matrix<double, nuisances, nuisances>;
    Ground ground = unknown.transpose().lazyProduct(unknown);
    const Eigen::Matrix<double, nuisances, 3> cross = unknown.transpose().lazyProduct(outline);
    block.outline = cross(0, 2);
    for (int j = 2; j < nuisances; ++j) {
        block.squares.at(static_cast<std::size_t>(j - 2)) = ground(j, j);
        ground(j, j) *= 1 + KnownSlope::most_frames;
    }
    const double n = ground(0, 0), spread = ground(1, 1) - ground(0, 1) * ground(0, 1) / std::max(n, 1.0);
    if (!(spread > least_spread * n) || n < nuisances + 3) return;  // not used: no information
    const Ground inverse = ground.inverse();
    const Eigen::Matrix<double, nuisances, 3> explained = inverse * cross;
    block.ground.setZero();
    block.ground.topLeftCorner<nuisances, nuisances>() = inverse;
    for (int k = 2; k < nuisances; ++k)
        block.by_slope.row(k - 2) =
            KnownSlope::most_frames * block.squares.at(static_cast<std::size_t>(k - 2)) * explained.row(k);
    const Eigen::Matrix3d all = outline.transpose().lazyProduct(outline);
    block.normal = all - cross.transpose() * explained;
    Eigen::Map<Eigen::MatrixX4f> weights{weights_of(place, b), range.padded, 4};
    weights.bottomRows(range.padded - count).setZero();
    weights.col(0).head(count) = unknown.col(1).template cast<float>();
    weights.topRows(count).rightCols<3>() = (outline - unknown.lazyProduct(explained)).template cast<float>();
}

// A picture in which all weights were missing would take several times as long as others.
void OutlineBank::learn_ahead() {
    if (ahead_ == 0) first_ahead_ = place_ / phases * phases;
    for (int sites = 0; ahead_ < blocks_.size() && sites < sites_ahead; ++ahead_) {
        const std::size_t b = ahead_ % ranges_.size();
        const std::size_t place = (first_ahead_ + ahead_ / ranges_.size()) % (phases * phases);
        if (learn(place, b)) sites += ranges_[b].end - ranges_[b].begin;
    }
}

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
        see(b, place);
    }
}

// What the values of a block show: its gain, its residual and its score for the outline.
void OutlineBank::see(std::size_t b, std::size_t place) {
    const Range& range = ranges_[b];
    const Block& block = block_at(place, b);
    const float* const weights = weights_of(place, b);
    std::array<Lanes, 4> weighted{};
    Lanes along{}, across{};
    Wide sum{}, squares{};
    for (int i = 0; i < range.padded; i += lanes) {
        const Lanes value = load<Lanes>(&values_[static_cast<std::size_t>(i)]);
        for (std::size_t k = 0; k < 4; ++k)
            weighted[k] += value * load<Lanes>(weights + static_cast<int>(k) * range.padded + i);
        const Wide exact = __builtin_convertvector(value, Wide);
        sum += exact;
        squares += exact * exact;
        if (!plane()) continue;
        along += value * load<Lanes>(&along_[static_cast<std::size_t>(range.weights / 4 + i)]);
        across += value * load<Lanes>(&across_[static_cast<std::size_t>(range.weights / 4 + i)]);
    }
    Eigen::Vector4d sums{total(sum), total(weighted[0]), total(along), total(across)};
    Seen& seen = seen_[b];
    seen.score = {total(weighted[1]), total(weighted[2]), total(weighted[3])};
    seen.freedom = range.end - range.begin - (plane() ? 4 : 2);
    double known = 0;  // squares of the known slope
    if (plane()) {
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

void OutlineBank::accept(std::span<KnownSlope> slopes) {
    for (std::size_t b = 0; b < seen_.size(); ++b) {
        Seen& s = seen_[b];
        if (!s.used) continue;
        if (plane()) slopes[b].learn(s.slope);
        s.habit_frames = std::min(s.habit_frames + 1, EdgeFit::longest_memory);
        s.habit += (s.off - s.habit) / s.habit_frames;
    }
    learn_ahead();
}

EdgeFitResult OutlineBank::fit(const ImageView& image, Point start, std::span<const KnownSlope> slopes) {
    slopes_ = slopes;
    Point at = start;
    double size = shape_.size;
    EdgeFitResult result;
    for (int step = 0; step < most_steps; ++step) {
        const int x = static_cast<int>(std::floor(at.x + 0.5)), y = static_cast<int>(std::floor(at.y + 0.5));
        const auto phase = [](double off) {
            return std::clamp(static_cast<int>((off + 0.5) * phases), 0, phases - 1);
        };
        const int i = phase(at.x - x), j = phase(at.y - y);
        const auto place = place_ = static_cast<std::size_t>(j * phases + i);
        const Point offset = offset_at(place);
        const bool thinned = step == 0 && ranges_.size() >= many;
        const auto look_at = [&](auto pixels) { look(pixels, place, x, y, whole(image), thinned); };
        image.bytes_per_pixel == 4 ? look_at(Pixels<float>{image}) : with_pixels(image, look_at);
        const auto looked = static_cast<double>(std::ranges::count_if(seen_, &Seen::used));
        choose_blocks();
        Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
        Eigen::Vector3d score = Eigen::Vector3d::Zero();
        double freedom = 0, squares = 0, outline = 0, used = 0;
        for (std::size_t b = 0; b < seen_.size(); ++b) {
            const Seen& s = seen_[b];
            if (!s.used) continue;
            normal += s.gain * s.gain * block_at(place, b).normal;
            score += s.score;
            freedom += s.freedom;
            squares += s.variance * s.freedom;
            outline += block_at(place, b).outline;
            used += 1;
        }
        if (!(freedom > 4)) {
            if (thinned) continue;
            return result;
        }
        const auto certain = [&](double variance) {
            Eigen::Matrix3d all = normal / variance;
            all(2, 2) += 1 / (shape_.size_sd * shape_.size_sd);
            if (shape_.straight) all(1, 1) += 1;
            return all;
        };
        double variance = std::max(squares / freedom, least_variance);
        const Eigen::Vector3d change = certain(variance).inverse() * score / variance;
        if (!change.allFinite()) return result;
        const Point found{x + offset.x + change[0], shape_.straight ? start.y : y + offset.y + change[1]};
        size = shape_.size + change[2];
        const bool settled =
            !thinned && std::abs(change[0]) <= 0.75 / phases && std::abs(change[1]) <= 0.75 / phases;
        if (settled) {
            if (plane() && tilted(place, change)) return result;
            // What the place on the grid leaves is no noise. With known slopes it stands for their error.
            if (!plane()) squares -= change.dot(2 * score - normal * change);
            variance = std::max(squares / freedom, least_variance);
            result.converged = true;
            result.outline = {found.x, found.y, size, shape_.blur};
            result.covariance =
                disagreement(place, change, variance) * certain(variance).inverse().topLeftCorner<2, 2>();
            result.contrast = contrast_;
            result.freedom = freedom;
            result.noise = std::sqrt(variance);
            result.coverage = outline;
            result.trimmed = 1 - used / std::max(looked, 1.0);
            return result;
        }
        const double far = std::hypot(change[0], change[1]);
        const double share = std::min(1.0, farthest_step / std::max(far, 1e-12));
        at = {x + offset.x + share * change[0], shape_.straight ? start.y : y + offset.y + share * change[1]};
        if (length(at - start) > farthest) return result;
    }
    return result;
}

}  // namespace shaker::tracking
