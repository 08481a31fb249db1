// The pixels and the weights of OutlineBank's filters.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tracking/image/edge_profile.hpp"
#include "tracking/image/outline_bank.hpp"

namespace shaker::tracking {
namespace {

constexpr double least_spread = 0.02;  // of E within a block, as in EdgeFit
constexpr int sites_ahead = 500;  // at least, whose weights are computed in a picture before they are needed

constexpr double few_frames = 4;  // whose worth of independent noise is believed before any is seen

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
    int longest = 0, all = 0;  // sites, in whole lanes
    for (Range& r : ranges_) {
        r.padded = (r.end - r.begin + lanes - 1) / lanes * lanes;
        r.first = all;
        all += r.padded;
        longest = std::max(longest, r.padded);
    }
    weights_a_place_ = columns_a_site() * static_cast<std::size_t>(all);
    blocks_.assign(phases * phases * ranges_.size(), {});
    ahead_ = 0;
    weights_ = std::make_unique_for_overwrite<float[]>(phases * phases * weights_a_place_);
    values_.assign(static_cast<std::size_t>(longest), 0);
    level_ = static_cast<float>(std::lround(shape_.level));
    along_.assign(static_cast<std::size_t>(all), 0);
    across_.assign(static_cast<std::size_t>(all), 0);
    for (const Range& r : ranges_) {
        for (int i = r.begin; i < r.end; ++i) {
            const auto at = static_cast<std::size_t>(r.first + i - r.begin);
            along_[at] = static_cast<float>(sites_[static_cast<std::size_t>(i)].x - r.shift.x);
            across_[at] = static_cast<float>(sites_[static_cast<std::size_t>(i)].y - r.shift.y);
        }
    }
    seen_.assign(ranges_.size(), {});
    sorted_.reserve(ranges_.size());
    columns_.setOnes(longest, 7);
    faded_.setOnes(longest, 7);
    common_ = response_ = 1;
    common_frames_ = few_frames;
    response_frames_ = 0;
}

void OutlineBank::resize(double size, double blur) noexcept {
    shape_.size = size;
    shape_.blur = blur;
    for (Block& b : blocks_) b.known = false;
    ahead_ = 0;
    response_frames_ = std::min(response_frames_, 2.0);  // another blur has another one
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
        faded_.row(i) = (nuisances == 2 ? faded(shape_.size - r, shape_.reach) : 1.0) * columns_.row(i);
    }
    // lazyProduct() allocates nothing.
    const auto unknown = columns_.topRows(count).leftCols<nuisances>();
    const auto outline = columns_.topRows(count).middleCols<3>(4);
    const auto faded_unknown = faded_.topRows(count).leftCols<nuisances>();
    const auto faded_outline = faded_.topRows(count).middleCols<3>(4);
    using Ground = Eigen::Matrix<double, nuisances, nuisances>;
    Ground ground = unknown.transpose().lazyProduct(faded_unknown);
    const Eigen::Matrix<double, nuisances, 3> cross = faded_unknown.transpose().lazyProduct(outline);
    block.outline = cross(0, 2);
    block.weight = ground(0, 0);
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
    const Eigen::Matrix3d all = outline.transpose().lazyProduct(faded_outline);
    const Eigen::Matrix3d response = all - cross.transpose() * explained;
    float* const to = weights_of(place, b);
    if constexpr (nuisances == 4) {
        block.normal = response;
        Eigen::Map<Eigen::MatrixX4f> weights{to, range.padded, 4};
        weights.bottomRows(range.padded - count).setZero();
        weights.col(0).head(count) = unknown.col(1).template cast<float>();
        weights.topRows(count).template rightCols<3>() =
            (outline - unknown.lazyProduct(explained)).template cast<float>();
    } else {
        // The sum of squares of the weights is the variance of their score, which is less than its derivative
        // where weights fade out.
        Eigen::Map<Eigen::MatrixX3f> weights{to, range.padded, 3};
        weights.bottomRows(range.padded - count).setZero();
        weights.col(0).head(count) = faded_unknown.col(0).template cast<float>();
        weights.col(1).head(count) = faded_unknown.col(1).template cast<float>();
        weights.col(2).head(count) =
            (faded_outline.col(2) - faded_unknown.lazyProduct(explained.col(2))).template cast<float>();
        const double variance = weights.col(2).template cast<double>().squaredNorm();
        block.lead = response.row(2).transpose() / variance;
        block.normal = block.lead * response.row(2);
        block.share = variance / response(2, 2);
    }
}

// A picture in which all weights were missing would take several times as long as others.
void OutlineBank::learn_ahead() {
    if (ahead_ == 0) first_ahead_ = place_;
    for (int sites = 0; ahead_ < blocks_.size() && sites < sites_ahead; ++ahead_) {
        const std::size_t b = ahead_ % ranges_.size();
        const std::size_t n = ahead_ / ranges_.size();  // along the row first, from the place on
        const std::size_t row = (first_ahead_ / phases + n / phases) % phases;
        const std::size_t place = row * phases + (first_ahead_ + n) % phases;
        if (learn(place, b)) sites += ranges_[b].end - ranges_[b].begin;
    }
}

}  // namespace shaker::tracking
