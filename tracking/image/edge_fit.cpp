#include "tracking/image/edge_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "tracking/image/edge_profile.hpp"

namespace shaker::tracking {
namespace {

constexpr double lost_by_biweight = 1.2;  // variance / biweighted variance for Gaussian residuals
constexpr double loose = 1e-2;            // after many passes
constexpr int last_scale = 3;
constexpr double smallest_blur = 0.3, largest_blur = 8;

// Tukey's biweight, cut at slightly more than four standard deviations: 95 % efficient for Gaussian noise.
// certainty: 1 / variance.
double biweight(double residual_squared, double certainty) noexcept {
    const double t = std::max(1 - residual_squared * (certainty / 22), 0.0);
    return t * t;
}

// Upper triangle of gram += weight c c^T, in pairs: the hot spot of the fit.
template <class Gram, class Row, std::size_t... i>
void add_products(Gram& gram, const Row& c, double weight, std::index_sequence<i...>) noexcept {
    constexpr int columns = Row::ColsAtCompileTime;
    const auto add_row = [&]<int from, int row>() {
        gram.template block<1, columns - from>(row, from) +=
            (weight * c[row]) * c.template segment<columns - from>(from);
    };
    (add_row.template operator()<(static_cast<int>(i) & ~1), static_cast<int>(i)>(), ...);
}

}  // namespace

template <std::size_t nuisances>
void EdgeFit::accumulate(const Outline& at, double reach, bool trim) {
    constexpr std::size_t value_column = nuisances + 4, columns = nuisances + 6;  // the last one is padding
    for (Block& b : blocks_) {
        b.gram.setZero();
        b.weight = b.trimmed = b.whole = b.coverage = 0;
    }
    // No lens draws a Gaussian edge better than this: without noise, its tails must not become outliers.
    const double perfect = 2e-3 * contrast_;
    const double certainty = 1 / std::max(scale_, 1.0 / 12 + perfect * perfect);
    // Two short loops are faster than a long one: a processor then works on several samples at a time.
    using Row = Eigen::Matrix<double, 1, static_cast<int>(columns)>;
    std::array<Row, 32> rows;
    std::array<double, 32> weights, fades;
    for (std::size_t from = 0; from < samples_.size(); from += rows.size()) {
        const std::size_t count = std::min(rows.size(), samples_.size() - from);
        for (std::size_t i = 0; i < count; ++i) {
            const EdgeSample& s = samples_[from + i];
            const Block& b = blocks_[static_cast<std::size_t>(s.block)];
            const double du = s.u - at.x, dv = s.v - at.y;
            const double r = std::sqrt(du * du + dv * dv);
            const auto [e, g, by_blur] = upright_ ? EdgeProfile::upright(at.size - r, at.blur)
                                                  : EdgeProfile::round(at.size - r, at.blur);
            const double per_r = g / std::max(r, 1e-9);
            Row& c = rows[i];
            c[0] = 1;
            c[1] = e;
            double ground = b.ground[0] + b.ground[1] * e;
            if constexpr (nuisances == 4) {
                c[2] = du;
                c[3] = dv;
                ground += b.ground[2] * du + b.ground[3] * dv;
            }
            c[nuisances] = du * per_r;
            c[nuisances + 1] = dv * per_r;
            c[nuisances + 2] = g;
            c[nuisances + 3] = by_blur;
            c[value_column] = s.value;
            c[value_column + 1] = 0;
            fades[i] = nuisances == 2 ? faded(at.size - r, reach) : 1;
            weights[i] = trim ? biweight((s.value - ground) * (s.value - ground), certainty) : 1;
        }
        for (std::size_t i = 0; i < count; ++i) {
            Block& b = blocks_[static_cast<std::size_t>(samples_[from + i].block)];
            const double weight = fades[i] * weights[i];
            b.weight += weight;
            b.trimmed += weights[i] < 0.5 ? fades[i] : 0;
            b.whole += fades[i];
            b.coverage += weight * rows[i][nuisances + 2];
            add_products(b.gram, rows[i], weight, std::make_index_sequence<value_column + 1>{});
        }
    }
}

// Eliminates gain, offset and plane: the remainder is the block's information on the outline.
template <std::size_t nuisances>
void EdgeFit::solve_block(Block& b, const KnownSlope& slope, double spread_lost) const {
    constexpr auto n = static_cast<int>(nuisances);
    b.used = false;
    if (b.weight < n + 3) return;
    using Full = Eigen::Matrix<double, n + 5, n + 5>;
    Full gram;
    for (int i = 0; i < n + 5; ++i) {
        for (int j = i; j < n + 5; ++j) {
            gram(i, j) = gram(j, i) = b.gram(i, j);
        }
    }
    const double spread = gram(1, 1) - gram(0, 1) * gram(0, 1) / gram(0, 0);
    if (!(spread > 0.02 * b.weight)) return;  // only one side of the edge is in the picture
    Eigen::Matrix<double, n, 5> solved;
    Eigen::Matrix<double, 5, 5> schur;
    const auto eliminate = [&] {
        const Eigen::LLT<Eigen::Matrix<double, n, n>> llt{gram.template topLeftCorner<n, n>()};
        const Eigen::Matrix<double, n, 5> cross = gram.template topRightCorner<n, 5>();
        solved = llt.solve(cross);
        schur = gram.template bottomRightCorner<5, 5>() - cross.transpose() * solved;
        b.used = llt.info() == Eigen::Success;
    };
    eliminate();
    b.variance = spread_lost * std::max(schur(4, 4), 0.0) / std::max(b.weight - n, 1.0);
    if constexpr (n == 4) {
        const double contrast = solved(1, 4);
        b.own_slope = {solved(2, 4) / contrast, solved(3, 4) / contrast};
        const std::array<double, 2> squares{gram(2, 2), gram(3, 3)};
        if (slope.frames > 0 && !slope.differs(b.own_slope, b.variance / (contrast * contrast), squares)) {
            for (int i = 0; i < 2; ++i) {
                const auto k = static_cast<std::size_t>(i);
                const double known = slope.frames * squares.at(k);
                gram(2 + i, 2 + i) += known;
                gram(2 + i, n + 4) += known * contrast * slope.slope.at(k);
            }
            eliminate();
        }
    }
    for (int i = 0; i < n; ++i) b.ground[static_cast<std::size_t>(i)] = solved(i, 4);
    const double gain = b.ground[1];
    b.normal = gain * gain * schur.topLeftCorner<4, 4>();
    b.score = gain * schur.block<4, 1>(0, 4);
}

// Excludes blocks whose gain or residual differs from the others': they do not show the target's outline.
void EdgeFit::choose_blocks() {
    const auto median = [&](auto of) {
        sorted_.clear();
        for (const Block& b : blocks_) {
            if (b.used) sorted_.push_back(of(b));
        }
        if (sorted_.empty()) return 0.0;
        const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
        std::nth_element(sorted_.begin(), middle, sorted_.end());
        return *middle;
    };
    contrast_ = median([](const Block& b) { return b.ground[1]; });
    variance_ = median([](const Block& b) { return b.variance; });
    for (Block& b : blocks_) {
        b.used = b.used && !b.habit.strange(b.ground[1] / contrast_) && b.variance <= 16 * variance_ + 1e-9;
    }
}

template <std::size_t nuisances>
EdgeFit::Pass EdgeFit::run(const Outline& at, double reach, bool trim) {
    accumulate<nuisances>(at, reach, trim);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
        solve_block<nuisances>(blocks_[b], slopes_[b], trim ? lost_by_biweight : 1.0);
    choose_blocks();
    Pass pass;
    for (const Block& b : blocks_) {
        if (!b.used) continue;
        const double freedom = b.weight - static_cast<double>(nuisances);
        pass.normal += b.normal;
        pass.score += b.score;
        pass.weight += freedom;
        pass.variance += b.variance * freedom;
    }
    pass.variance = std::max(pass.variance / std::max(pass.weight, 1.0), 1e-4);
    pass.normal /= pass.variance;
    pass.score /= pass.variance;
    return pass;
}

EdgeFitResult EdgeFit::fit(const Outline& start, const EdgePrior& prior, int blocks, Ground ground,
                           int passes, double enough) {
    blocks_.resize(static_cast<std::size_t>(blocks));
    slopes_.resize(blocks_.size());
    const Eigen::Vector4d theta0{start.x, start.y, start.size, start.blur};
    const Eigen::Vector4d certainty =
        Eigen::Vector4d{prior.x, prior.y, prior.size, prior.blur}.cwiseMax(1e-6).array().square().inverse();
    Eigen::Vector4d theta = theta0;
    EdgeFitResult result;
    bool trim = false;
    for (int count = 0; count < passes && !result.converged; ++count) {
        const Outline at{theta[0], theta[1], theta[2], theta[3]};
        Pass pass = ground == Ground::plane ? run<4>(at, prior.reach, trim) : run<2>(at, prior.reach, trim);
        result.noise = std::sqrt(pass.variance);
        result.contrast = contrast_;
        result.freedom = pass.weight;
        const bool alike = prior.sign == 0 || result.noise < prior.roughest * prior.sign * contrast_;
        if (!(pass.weight > 4) || !alike) return result;
        pass.normal.diagonal() += certainty;
        pass.score += certainty.cwiseProduct(theta0 - theta);
        const Eigen::Matrix4d inverse = pass.normal.inverse();
        const Eigen::Vector4d step = inverse * pass.score;
        if (!step.allFinite()) return result;
        const double far = std::hypot(step[0], step[1]);
        // A scale that kept shrinking with the residuals would follow its own weights.
        const bool settled = count > last_scale || (trim && pass.variance > 0.8 * scale_);
        if (count <= last_scale) scale_ = variance_;
        result.converged = settled && trim && far < (count > 5 ? std::max(loose, enough) : enough);
        result.covariance = inverse.topLeftCorner<2, 2>();
        theta.head<2>() += std::min(1.0, 2.0 / std::max(far, 1e-12)) * step.head<2>();
        theta[2] += std::clamp(step[2], -0.5, 0.5);
        theta[3] = std::clamp(theta[3] + std::clamp(step[3], -0.3 * theta[3], 0.4 * theta[3]), smallest_blur,
                              largest_blur);
        trim = far < 0.3;
    }
    result.outline = {theta[0], theta[1], theta[2], theta[3]};
    if (result.converged) summarise(result);
    return result;
}

// Disagreement of blocks beyond their noise and learned offset (a reflection, an object in front) is added to
// the error.
void EdgeFit::summarise(EdgeFitResult& result) const {
    constexpr double far_beyond = 6, least_bent = 0.1;  // of the variance; px
    double disagreement = 0, squares = 0, normal = 0, count = 0, trimmed = 0, whole = 0;
    for (const Block& b : blocks_) {
        trimmed += b.trimmed;
        whole += b.whole;
        if (!b.used || !(b.normal(2, 2) > 0)) continue;
        const double off = b.score[2] / b.normal(2, 2) - b.habit.off;
        disagreement += off * off * b.normal(2, 2) / (result.noise * result.noise * b.habit.known());
        squares += off * off * b.normal(2, 2);
        normal += b.normal(2, 2);
        count += 1;
        result.coverage += b.coverage;
        for (std::size_t i = 0; i < 2; ++i) result.slope.at(i) += b.own_slope.at(i);
    }
    for (double& slope : result.slope) slope /= std::max(count, 1.0);
    const double factor = count > 6 ? std::max(1.0, disagreement / (count - 4)) : 1;
    result.covariance *= factor;
    if (factor > far_beyond && squares > least_bent * least_bent * normal)
        result.bent = std::sqrt(squares / normal);
    result.trimmed = trimmed / std::max(whole, 1.0);
}

void EdgeFit::forget() noexcept {
    std::ranges::fill(slopes_, KnownSlope{});
    for (Block& b : blocks_) b.habit = {};
}

void EdgeFit::accept() {
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
        Block& b = blocks_[k];
        if (!b.used || !(b.normal(2, 2) > 0)) {
            b.habit.pass_over();
            continue;
        }
        slopes_[k].learn(b.own_slope);
        b.habit.learn(b.score[2] / b.normal(2, 2), b.ground[1] / contrast_);
    }
}

}  // namespace shaker::tracking
