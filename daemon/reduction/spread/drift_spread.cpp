#include "daemon/reduction/spread/drift_spread.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "daemon/reduction/spread/mixture.hpp"

namespace shaker::reduction {
namespace {

constexpr double white_weight = 30;
constexpr double no_jitter_weight = 2.5, slight_jitter_weight = 0.08;
// Gain of the log-likelihood by an approach at which it is as likely as none, with a prior of few tails and
// for the choice of rate and amplitude; and below which it does not count.
constexpr double even_odds = 7, unlikely = 3;
constexpr double no_memory_weight = 0.75, memory_exponent = 0.8, most_memory = 0.99;

struct Candidate {
    Scatter scatter;
    std::array<int, 3> cell{};  // on the axes of error, jitter, memory; -1: the single value
    double log_weight = 0;
    double log_likelihood = 0;  // full
    double variance = 0;        // of the line's slope
    double inflation = 1;       // of that variance by memory
};

double rms_of_differences(std::span<const PeriodMean> means) {
    const double mean = (means.back().y_m - means.front().y_m) / (means.back().k - means.front().k);
    double squares = 0;
    for (std::size_t i = 1; i < means.size(); ++i) {
        const int steps = means[i].k - means[i - 1].k;
        squares += std::pow(means[i].y_m - means[i - 1].y_m - mean * steps, 2) / steps;
    }
    return std::sqrt(squares / static_cast<double>(means.size() - 1));
}

/// Noise with memory has between a quarter and all of the variance of a mean in the contrast.
double log_evidence_of_contrasts(double error2, const ScatterPrior& prior) {
    const double freedom = std::max(0, prior.contrasts - 1);  // the periodic fit removes their mean
    const double squares = freedom * prior.contrast_m * prior.contrast_m;
    constexpr std::array shares{1.0, 0.5, 0.25}, weights{0.6, 0.25, 0.15};
    std::array<double, 3> logs{};
    for (std::size_t i = 0; i < 3; ++i)
        logs[i] = -0.5 * (freedom * std::log(shares[i] * error2) + squares / (shares[i] * error2));
    const double most = std::ranges::max(logs);
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += weights[i] * std::exp(logs[i] - most);
    return most + std::log(sum);
}

/// Candidates for the scatter with their weights, on a grid that is narrowed to where the weight is.
class Posterior {
public:
    Posterior(std::span<const PeriodMean> means, const ScatterPrior& prior)
        : means_(means), prior_(prior), slope_(means) {
        const double rms = rms_of_differences(means);
        // Positions without noise still have rounding errors, and a likelihood needs a width.
        white_ = std::max(prior.white_m, 1e-15 + 1e-9 * rms);
        error_ = {std::log(white_), std::log(std::max({2 * rms, 3 * prior.contrast_m, 1.5 * white_})), 4};
        error_range_ = error_.high - error_.low;
        const double least = white_ * std::sqrt(slope_.of_error() / slope_.of_jitter(0));
        jitter_ = {std::log(least), std::log(std::max(10 * rms, 100 * least)), 14};
        memory_ = {0, std::log((1 + most_memory) / (1 - most_memory)), 8};
        constexpr int passes = 4;
        for (int pass = 0; pass < passes; ++pass) {
            weigh();
            if (!narrow()) break;
        }
    }
    [[nodiscard]] const std::vector<Candidate>& candidates() const noexcept { return all_; }
    [[nodiscard]] const Candidate& likeliest() const {
        return *std::ranges::max_element(all_, {}, &Candidate::log_weight);
    }

private:
    void weigh() {
        all_.clear();
        for (int e = -1; e < error_.cells; ++e) {
            const double error = e < 0 ? white_ : std::exp(error_.at(e)), error2 = error * error;
            const double log_prior = log_evidence_of_contrasts(error2, prior_) +
                                     std::log(e < 0 ? white_weight : error_.width() / error_range_);
            add_jitters(e, error2, log_prior);
        }
        std::vector<Scatter> scatters;
        scatters.reserve(all_.size());
        for (const Candidate& c : all_) scatters.push_back(c.scatter);
        const auto likelihoods = log_likelihoods(means_, scatters);
        for (std::size_t i = 0; i < all_.size(); ++i) {
            all_[i].log_weight += likelihoods[i].restricted;
            all_[i].log_likelihood = likelihoods[i].full;
        }
    }
    void add_jitters(int e, double error2, double log_prior) {
        const double own = error2 * slope_.of_error(), plain = slope_.of_jitter(0);
        all_.push_back({{error2, 0, 0}, {e, -1, -1}, log_prior + std::log(no_jitter_weight), 0, own, 1});
        for (int r = -1; r < memory_.cells; ++r) {
            const double x = r < 0 ? 1 : std::exp(memory_.at(r)), memory = (x - 1) / (x + 1);
            const double by_jitter = slope_.of_jitter(memory);
            const double log_memory =
                std::log(r < 0 ? no_memory_weight
                               : (1 - no_memory_weight) * memory_exponent * memory_.width()) -
                memory_exponent * std::log(x);
            for (int j = 0; j < jitter_.cells; ++j) {
                const double jitter = std::exp(jitter_.at(j)), jitter2 = jitter * jitter;
                const double weight = jitter_.width() * (jitter < prior_.jitter_m ? slight_jitter_weight : 1);
                const double variance = own + jitter2 * by_jitter;
                all_.push_back({{error2, jitter2, memory},
                                {e, j, r},
                                log_prior + log_memory + std::log(weight),
                                0,
                                variance,
                                variance / (own + jitter2 * plain)});
            }
        }
    }
    /// False when the grid does not become much narrower.
    bool narrow() {
        const double enough = likeliest().log_weight - 7;
        bool narrower = false;
        const std::array<Axis*, 3> axes{&error_, &jitter_, &memory_};
        for (std::size_t a = 0; a < 3; ++a) {
            Axis& axis = *axes[a];
            int first = axis.cells, last = -1;
            for (const Candidate& c : all_) {
                if (c.log_weight < enough || c.cell[a] < 0) continue;
                first = std::min(first, c.cell[a]);
                last = std::max(last, c.cell[a]);
            }
            if (last < 0) continue;
            const double low = std::max(axis.low, axis.low + (first - 0.5) * axis.width()),
                         high = std::min(axis.high, axis.low + (last + 1.5) * axis.width());
            narrower = narrower || high - low < 0.6 * (axis.high - axis.low);
            axis.low = low;
            axis.high = high;
        }
        return narrower;
    }

    std::span<const PeriodMean> means_;
    ScatterPrior prior_;
    SlopeVariance slope_;
    double white_ = 0, error_range_ = 0;
    Axis error_, jitter_, memory_;  // ln m, ln m, ln (1 + r)/(1 - r)
    std::vector<Candidate> all_;
};

double half_width_95(const Posterior& posterior) {
    const double best = posterior.likeliest().log_weight;
    std::vector<NormalPart> parts;
    for (const Candidate& c : posterior.candidates()) {
        const double weight = std::exp(c.log_weight - best);
        if (weight >= 1e-5) parts.push_back({weight, c.variance});
    }
    return half_width_95(parts);
}

double median_inflation(const Posterior& posterior) {
    const double best = posterior.likeliest().log_weight;
    std::vector<std::pair<double, double>> parts;  // inflation, weight
    double total = 0, sum = 0;
    for (const Candidate& c : posterior.candidates()) {
        parts.emplace_back(c.inflation, std::exp(c.log_weight - best));
        total += parts.back().second;
    }
    std::ranges::sort(parts);
    for (const auto& [inflation, weight] : parts) {
        sum += weight;
        if (sum >= total / 2) return inflation;
    }
    return 1;
}

struct FoundApproach {
    Approach approach;
    double contraction = 0;
    double settled_sd_m = 0;  // with the error of the contraction
    double weight = 0;
};

/// Candidates for the scatter about an approach: at most that of the likeliest one without it.
std::vector<Scatter> smaller(const Scatter& most) {
    std::vector<Scatter> out{{most.error2, 0, 0}};
    for (double j = most.jitter2; j > 1e-6 * most.error2 && out.size() < 15; j /= 8)
        for (const double memory : {0.0, 0.8}) out.push_back({most.error2, j, memory});
    return out;
}

/// The likeliest approach with contraction e^-rate.
Approach approach_at(std::span<const PeriodMean> means, std::span<const Scatter> scatters, double rate) {
    const auto all = approaches(means, scatters, std::exp(-rate));
    return *std::ranges::max_element(all, {}, &Approach::log_likelihood);
}

/// The approach that the means show, unless it is unlikely.
std::optional<FoundApproach> find_approach(std::span<const PeriodMean> means, const Posterior& posterior) {
    if (means.size() < 8) return {};
    double without = -std::numeric_limits<double>::infinity();
    for (const Candidate& c : posterior.candidates()) without = std::max(without, c.log_likelihood);
    const std::vector<Scatter> scatters = smaller(posterior.likeliest().scatter);
    Approach best{.log_likelihood = -std::numeric_limits<double>::infinity()};
    double rate = 0, step = 0.25;                                     // of ln rate
    const double slowest = 1.6 / (means.back().k - means.front().k);  // else the settled value is not seen
    for (double r = 1.2; r > slowest; r *= std::exp(-2 * step)) {
        const Approach a = approach_at(means, scatters, r);
        if (a.log_likelihood > best.log_likelihood) best = a, rate = r;
    }
    if (best.log_likelihood < without + unlikely) return {};
    for (int i = 0; i < 10; ++i, step /= 2) {
        for (const double r : {rate * std::exp(-step), rate * std::exp(step)}) {
            const Approach a = approach_at(means, scatters, r);
            if (a.log_likelihood > best.log_likelihood) best = a, rate = r;
        }
    }
    // Error of the rate from the curvature of the likelihood.
    const Approach slower = approach_at(means, scatters, rate * std::exp(-4 * step)),
                   faster = approach_at(means, scatters, rate * std::exp(4 * step));
    const double curvature =
        (2 * best.log_likelihood - slower.log_likelihood - faster.log_likelihood) / (16 * step * step);
    const double by_rate =
        (faster.settled_m - slower.settled_m) / (8 * step) / std::sqrt(std::max(curvature, 1.0));
    const double weight = 1 / (1 + std::exp(even_odds - (best.log_likelihood - without)));
    return FoundApproach{best, std::exp(-rate), std::hypot(best.settled_sd_m, by_rate), weight};
}

/// The means without the approach.
std::vector<PeriodMean> settled(std::span<const PeriodMean> means, const FoundApproach& approach) {
    std::vector<PeriodMean> out{means.begin(), means.end()};
    for (PeriodMean& m : out)
        m.y_m -=
            approach.approach.amplitude_m * walked_in_approach(approach.contraction, m.k - means.front().k);
    return out;
}

}  // namespace

double few_periods_factor(int freedom) {
    if (freedom < 1) return std::numeric_limits<double>::infinity();
    return boost::math::quantile(boost::math::students_t(freedom), 0.975) / 2;
}

DriftSpread drift_spread(std::span<const PeriodMean> means, const ScatterPrior& prior) {
    DriftSpread out;
    if (means.size() < 3) {
        out.sigma_m = std::numeric_limits<double>::infinity();
        return out;
    }
    std::optional<Posterior> posterior(std::in_place, means, prior);
    const auto approach = find_approach(means, *posterior);
    std::vector<PeriodMean> rest;
    if (approach) {
        const Approach& a = approach->approach;
        const int n = static_cast<int>(means.size());
        out.settling = {
            {a.settled_m, approach->settled_sd_m * few_periods_factor(n - 4)},
            a.amplitude_m * (std::pow(approach->contraction, means.back().k - means.front().k) - 1),
            approach->weight};
        rest = settled(means, *approach);
        if (approach->weight > 0.5) posterior.emplace(rest, prior);
    }
    const Scatter& best = posterior->likeliest().scatter;
    out.sigma_m = half_width_95(*posterior) / 2;
    out.jitter_m = std::sqrt(best.jitter2);
    out.mean_error_m = std::sqrt(best.error2);
    out.memory = best.memory;
    out.independent = static_cast<double>(means.size()) / median_inflation(*posterior);
    return out;
}

}  // namespace shaker::reduction
