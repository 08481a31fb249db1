#include "daemon/reduction/spread/drift_likelihood.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>

namespace shaker::reduction {
namespace {

constexpr int width = 8;  // candidates filtered together
using Lanes = Eigen::Array<double, width, 1>;

/// State of a lane: position X and deviation u of the drift, for the data and each regressor.
template <int Series>
struct Filter {
    Lanes p_xx = Lanes::Zero(), p_xu = Lanes::Zero(), p_uu;  // covariance
    std::array<Lanes, Series> x, u;
    std::array<std::array<Lanes, Series>, Series> products;  // of the whitened series
    Lanes log_determinant = Lanes::Zero(), variances = Lanes::Ones();
    int factors = 0;  // in `variances`; a logarithm costs as much as a step

    explicit Filter(const Lanes& jitter2) : p_uu(jitter2) {
        x.fill(Lanes::Zero());
        u.fill(Lanes::Zero());
        for (auto& row : products) row.fill(Lanes::Zero());
    }
    void see(const std::array<double, Series>& y, const Lanes& error2) {
        const Lanes variance = p_xx + p_xu + p_uu / 4 + error2, inverse = 1 / variance;
        const Lanes c_x = p_xx + p_xu / 2, c_u = p_xu + p_uu / 2, gain_x = c_x * inverse,
                    gain_u = c_u * inverse;
        std::array<Lanes, Series> innovation;
        for (std::size_t i = 0; i < Series; ++i) {
            innovation[i] = y[i] - x[i] - u[i] / 2;
            x[i] += gain_x * innovation[i];
            u[i] += gain_u * innovation[i];
            const Lanes scaled = innovation[i] * inverse;
            for (std::size_t j = 0; j <= i; ++j) products[i][j] += scaled * innovation[j];
        }
        variances *= variance;
        if (++factors == 8) collect();
        p_xx -= gain_x * c_x;
        p_xu -= gain_x * c_u;
        p_uu -= gain_u * c_u;
    }
    void collect() {
        log_determinant += variances.log();
        variances = 1;
        factors = 0;
    }
    void step(const Lanes& memory, const Lanes& fresh2) {
        for (std::size_t i = 0; i < Series; ++i) {
            x[i] += u[i];
            u[i] *= memory;
        }
        p_xx += 2 * p_xu + p_uu;
        p_xu = memory * (p_xu + p_uu);
        p_uu = memory * memory * p_uu + fresh2;
    }
};

/// Sums of one candidate.
template <int Series>
struct Sums {
    Eigen::Matrix<double, Series - 1, Series - 1> normal;  // of the regressors
    Eigen::Matrix<double, Series - 1, 1> right;
    double squares = 0, log_determinant = 0;
};

double mean_frames(std::span<const PeriodMean> means) {
    double frames = 0;
    for (const PeriodMean& m : means) frames += m.frames;
    return frames / static_cast<double>(means.size());
}

/// values(k): the regressors of period k after the first.
template <int Series>
std::vector<Sums<Series>> filtered(std::span<const PeriodMean> means, std::span<const Scatter> candidates,
                                   auto values) {
    const double typical = mean_frames(means);
    std::vector<Sums<Series>> out;
    out.reserve(candidates.size());
    for (std::size_t begin = 0; begin < candidates.size(); begin += width) {
        Lanes error2, jitter2, memory;
        for (int lane = 0; lane < width; ++lane) {
            const Scatter& c =
                candidates[std::min(begin + static_cast<std::size_t>(lane), candidates.size() - 1)];
            error2(lane) = c.error2;
            jitter2(lane) = c.jitter2;
            memory(lane) = c.memory;
        }
        const Lanes fresh2 = jitter2 * (1 - memory * memory);
        Filter<Series> filter(jitter2);
        int k = means.front().k;
        for (const PeriodMean& m : means) {
            for (; k < m.k; ++k) filter.step(memory, fresh2);
            std::array<double, Series> y = values(m.k - means.front().k);
            y.back() = m.y_m;
            filter.see(y, error2 * (typical / m.frames));
        }
        filter.collect();
        for (int lane = 0; lane < width && out.size() < candidates.size(); ++lane) {
            Sums<Series>& s = out.emplace_back();
            for (std::size_t i = 0; i < Series - 1; ++i) {
                s.right(static_cast<Eigen::Index>(i)) = filter.products[Series - 1][i](lane);
                for (std::size_t j = 0; j <= i; ++j) {
                    const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
                    s.normal(a, b) = s.normal(b, a) = filter.products[i][j](lane);
                }
            }
            s.squares = filter.products[Series - 1][Series - 1](lane);
            s.log_determinant = filter.log_determinant(lane);
        }
    }
    return out;
}

}  // namespace

std::vector<LogLikelihood> log_likelihoods(std::span<const PeriodMean> means,
                                           std::span<const Scatter> candidates) {
    std::vector<LogLikelihood> out;
    out.reserve(candidates.size());
    for (const auto& s : filtered<3>(means, candidates, [](int k) {
             return std::array<double, 3>{1, static_cast<double>(k), 0};
         })) {
        const double full =
            -0.5 * (s.log_determinant + s.squares - s.right.dot(s.normal.inverse() * s.right));
        out.push_back({full - 0.5 * std::log(s.normal.determinant()), full});
    }
    return out;
}

double walked_in_approach(double contraction, int k) {
    const double power = std::pow(contraction, k);
    return (1 - power) / (1 - contraction) + power / 2;
}

std::vector<Approach> approaches(std::span<const PeriodMean> means, std::span<const Scatter> candidates,
                                 double contraction) {
    std::vector<Approach> out;
    out.reserve(candidates.size());
    const auto values = [&](int k) {
        return std::array<double, 4>{1, static_cast<double>(k), walked_in_approach(contraction, k), 0};
    };
    for (const auto& s : filtered<4>(means, candidates, values)) {
        const Eigen::Matrix3d inverse = s.normal.inverse();
        const Eigen::Vector3d c = inverse * s.right;
        out.push_back(
            {-0.5 * (s.log_determinant + s.squares - s.right.dot(c)), c(1), std::sqrt(inverse(1, 1)), c(2)});
    }
    return out;
}

SlopeVariance::SlopeVariance(std::span<const PeriodMean> means) {
    double frames = 0, centre = 0, total = 0;
    for (const PeriodMean& m : means) {
        frames += m.frames;
        centre += static_cast<double>(m.frames) * m.k;
    }
    centre /= frames;
    for (const PeriodMean& m : means) total += m.frames * (m.k - centre) * (m.k - centre);
    error_ = frames / static_cast<double>(means.size()) / total;
    double after = 0;  // sum of the weights of later means
    auto m = means.rbegin();
    for (int k = means.back().k; k >= means.front().k; --k) {
        const bool seen = m->k == k;
        const double weight = seen ? m->frames * (k - centre) / total : 0;
        if (seen) ++m;
        later_.push_back(after + weight / 2);
        after += weight;
    }
}

double SlopeVariance::of_jitter(double memory) const noexcept {
    double variance = 0, before = 0;
    for (const double w : later_) {
        variance += w * (w + 2 * before);
        before = memory * (before + w);
    }
    return variance;
}

}  // namespace shaker::reduction
