#include "daemon/reduction/spread/common_scatter.hpp"

#include <array>
#include <numeric>

#include "daemon/reduction/spread/mixture.hpp"

namespace shaker::reduction {
namespace {

/// ln of: error / white_m, jitter / response_m, (1 + memory)/(1 - memory). Before each axis lies the value of
/// white noise, of no jitter, of no memory.
constexpr Axis excess_axis{0, 3, 8}, jitter_axis{-9.2, -0.45, 25}, memory_axis{0, 5.3, 12};
constexpr std::size_t excesses = 1 + excess_axis.cells, jitters = 1 + jitter_axis.cells,
                      memories = 1 + memory_axis.cells;
constexpr std::size_t cells = excesses * jitters * memories;
using Weights = std::vector<double>;

constexpr double share_of_strangers = 0.05;

/// One candidate for the scatter of a walker, relative to the numbers of a record.
struct Shape {
    double excess = 1, jitter = 0, memory = 0;
    double prior = 0;
};

const std::vector<Shape>& shapes() {
    static const std::vector<Shape> all = [] {
        std::vector<Shape> out;
        double total = 0;
        for (int e = -1; e < excess_axis.cells; ++e)
            for (int j = -1; j < jitter_axis.cells; ++j)
                for (int r = -1; r < memory_axis.cells; ++r) {
                    const double x = r < 0 ? 1 : std::exp(memory_axis.at(r));
                    Shape s{e < 0 ? 1 : std::exp(excess_axis.at(e)), j < 0 ? 0 : std::exp(jitter_axis.at(j)),
                            (x - 1) / (x + 1)};
                    s.prior = (e < 0 ? 100 : 1.0 / excess_axis.cells) *
                              (j < 0 ? 2.5 : jitter_axis.width() * (s.jitter < 0.003 ? 0.5 : 1)) *
                              (r < 0 ? 0.6 : 0.4 / memory_axis.cells);
                    total += s.prior;
                    out.push_back(s);
                }
        for (Shape& s : out) s.prior /= total;
        return out;
    }();
    return all;
}

/// Each value is shared with its neighbours on the axis, from index `first` on.
void smear(Weights& w, std::size_t stride, std::size_t count, std::size_t first) {
    const Weights was = w;
    for (std::size_t i = 0; i < w.size(); ++i) {
        const std::size_t at = i / stride % count;
        if (at < first) continue;
        const double below = was[at > first ? i - stride : i], above = was[at + 1 < count ? i + stride : i];
        w[i] = 0.25 * below + 0.5 * was[i] + 0.25 * above;
    }
}

/// From the numbers of the walker to those of a record, and back.
Weights as_records_differ(Weights w) {
    smear(w, jitters * memories, excesses, 0);
    smear(w, memories, jitters, 1);
    smear(w, 1, memories, 0);
    return w;
}

Weights likelihoods_of(const WalkerRecord& record) {
    std::vector<Scatter> scatters;
    scatters.reserve(cells);
    for (const Shape& s : shapes())
        scatters.push_back(
            {std::pow(s.excess * record.white_m, 2), std::pow(s.jitter * record.response_m, 2), s.memory});
    Weights out;
    out.reserve(cells);
    for (const LogLikelihood& l : log_likelihoods(record.means, scatters)) out.push_back(l.restricted);
    const double most = std::ranges::max(out);
    for (double& w : out) w = std::exp(w - most);
    return out;
}

/// ln of the likelihood of the walker's numbers by one record.
Weights evidence_of(const Weights& likelihoods) {
    double stranger = 0;
    for (std::size_t i = 0; i < cells; ++i) stranger += shapes()[i].prior * likelihoods[i];
    Weights out = as_records_differ(likelihoods);
    for (double& w : out) w = std::log((1 - share_of_strangers) * w + share_of_strangers * stranger);
    return out;
}

/// What the other records say of one: `evidence` is theirs.
Weights expected_of(const Weights& evidence) {
    const double most = std::ranges::max(evidence);
    Weights out;
    for (std::size_t i = 0; i < cells; ++i) out.push_back(shapes()[i].prior * std::exp(evidence[i] - most));
    out = as_records_differ(out);
    const double total = std::accumulate(out.begin(), out.end(), 0.0);
    for (std::size_t i = 0; i < cells; ++i)
        out[i] = (1 - share_of_strangers) * out[i] / total + share_of_strangers * shapes()[i].prior;
    return out;
}

double sigma_of(const WalkerRecord& record, const Weights& likelihoods, const Weights& expected) {
    std::vector<PeriodMean> all;
    for (int k = 0; k < record.periods; ++k) all.push_back({k, 0, 1});
    const SlopeVariance slope(all);
    std::array<double, memories> by_jitter{};
    for (std::size_t r = 0; r < memories; ++r) by_jitter[r] = slope.of_jitter(shapes()[r].memory);
    Weights weights;
    for (std::size_t i = 0; i < cells; ++i) weights.push_back(likelihoods[i] * expected[i]);
    const double least = 1e-5 * std::ranges::max(weights);
    std::vector<NormalPart> parts;
    for (std::size_t i = 0; i < cells; ++i) {
        const Shape& s = shapes()[i];
        if (weights[i] >= least)
            parts.push_back(
                {weights[i], std::pow(s.excess * record.white_m, 2) * slope.of_error() +
                                 std::pow(s.jitter * record.response_m, 2) * by_jitter[i % memories]});
    }
    return half_width_95(parts) / 2;
}

}  // namespace

std::vector<double> common_sigmas(std::span<const WalkerRecord> records) {
    Weights all(cells, 0.0);
    for (const WalkerRecord& record : records) {
        const Weights evidence = evidence_of(likelihoods_of(record));
        for (std::size_t i = 0; i < cells; ++i) all[i] += evidence[i];
    }
    std::vector<double> out;
    for (const WalkerRecord& record : records) {
        const Weights likelihoods = likelihoods_of(record);
        Weights others = evidence_of(likelihoods);
        for (std::size_t i = 0; i < cells; ++i) others[i] = all[i] - others[i];
        out.push_back(sigma_of(record, likelihoods, expected_of(others)));
    }
    return out;
}

}  // namespace shaker::reduction
