#include "daemon/reduction/kinked_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "daemon/reduction/timeline.hpp"

namespace shaker::reduction {
namespace {

/// How probable places and lengths of one zone are.
struct Belief {
    std::vector<Zone> zones;
    std::vector<double> weights;  // sum 1
    double length = 0, length_sd = 0, middle = 0, middle_sd = 0;
    double longest = 0;  // 19 of 20 are shorter
    [[nodiscard]] const Zone& at(double share) const {
        double sum = 0;
        for (std::size_t i = 0; i < zones.size(); ++i)
            if ((sum += weights[i]) >= share) return zones[i];
        return zones.back();
    }
};

void judge(Belief& b, std::vector<double> misfits) {
    const double least = *std::ranges::min_element(misfits);
    double sum = 0;
    for (double& m : misfits) sum += m = std::exp((least - m) / 2);
    b.weights = std::move(misfits);
    b.length = b.middle = b.length_sd = b.middle_sd = 0;
    for (std::size_t i = 0; i < b.zones.size(); ++i) {
        b.weights[i] /= sum;
        b.length += b.weights[i] * b.zones[i].length;
        b.middle += b.weights[i] * b.zones[i].middle;
    }
    for (std::size_t i = 0; i < b.zones.size(); ++i) {
        b.length_sd += b.weights[i] * std::pow(b.zones[i].length - b.length, 2);
        b.middle_sd += b.weights[i] * std::pow(b.zones[i].middle - b.middle, 2);
    }
    b.length_sd = std::sqrt(b.length_sd);
    b.middle_sd = std::sqrt(b.middle_sd);
}

/// Searches place and length of zone k on grids that shrink around what is probable.
Belief search(const Timeline& line, std::span<const Node> window, std::vector<Zone>& zones, std::size_t k,
              double intensity, double reach, double longest) {
    constexpr int places = 11, lengths = 7, rounds = 5;
    double from = zones[k].middle - reach, to = zones[k].middle + reach, shortest = 0;
    Belief b;
    for (int round = 0; round < rounds; ++round) {
        const double step = (to - from) / (places - 1), length_step = (longest - shortest) / (lengths - 1);
        b.zones.clear();
        std::vector<double> misfits;
        for (int j = 0; j < lengths; ++j)
            for (int i = 0; i < places; ++i) {
                zones[k].middle = from + i * step;
                zones[k].length = shortest + j * length_step;
                b.zones.push_back(zones[k]);
                misfits.push_back(line.misfit(window, zones, intensity));
            }
        judge(b, std::move(misfits));
        zones[k].middle = b.middle;
        zones[k].length = b.length;
        if (b.middle_sd > 0.7 * step && b.length_sd > 0.7 * length_step) break;
        if (round + 1 == rounds) break;
        const double wide = std::max(3 * b.middle_sd, 1.2 * step),
                     long_by = std::max(3 * b.length_sd, 1.2 * length_step);
        from = b.middle - wide;
        to = b.middle + wide;
        shortest = std::max(0.0, b.length - long_by);
        longest = b.length + long_by;
    }
    std::array<double, lengths> by_length{};
    for (std::size_t i = 0; i < b.zones.size(); ++i) by_length[i / places] += b.weights[i];
    double sum = 0;
    for (std::size_t j = 0; j < lengths && sum <= 0.95; ++j) {
        b.longest = b.zones[j * places].length;
        sum += by_length[j];
    }
    return b;
}

/// Positions merged in steps of 1/400 period, from half a period before the period to half a period after it,
/// and the phases asked for.
std::vector<Node> nodes_of(std::span<const Folded> folded, double D, std::span<const double> phases,
                           double scale, Scales scales) {
    constexpr double bin = 1 / 400.0;
    std::vector<Node> merged;
    double begin = -1, weights = 0;
    for (const Folded& s : folded) {
        if (s.phase - begin > bin) {
            begin = s.phase;
            weights = 0;
            merged.push_back({.seen = true});
        }
        Node& n = merged.back();
        const double w = 1 / (s.sd_m * s.sd_m);
        weights += w;
        n.p += (s.phase - n.p) * w / weights;
        n.x += (s.x_m + D * s.phase - n.x) * w / weights;
        n.variance = 1 / weights;
    }
    std::vector<Node> out;
    for (const double turn : {-1.0, 0.0, 1.0})
        for (const Node& n : merged) {
            if (n.p + turn < -0.5 || n.p + turn > 1.5) continue;
            out.push_back({n.p + turn, true, (n.x + D * turn) / scales.x_m,
                           n.variance * scale * scale / (scales.x_m * scales.x_m)});
        }
    for (std::size_t i = 0; i < phases.size(); ++i)
        out.push_back({.p = phases[i], .wanted = static_cast<int>(i)});
    std::ranges::stable_sort(out, {}, &Node::p);
    return out;
}

std::span<const Node> within(std::span<const Node> nodes, double from, double to) {
    const auto first = std::ranges::lower_bound(nodes, from, {}, &Node::p);
    const auto last = std::ranges::upper_bound(nodes, to, {}, &Node::p);
    return {first, last};
}

Looseness looseness(const Cycle& c, std::span<const Kink> kinks, double jump, double period, double frame) {
    const std::size_t n = c.phase.size();
    std::vector<double> v;
    for (std::size_t i = 0; i < n; ++i) {  // 0 where too few positions are near
        const double v_R = c.v_mps[i] - c.v_base_mps[i];
        v.push_back(std::isfinite(v_R) ? v_R : 0);
    }
    double most = 0;
    for (const double x : v) most = std::max(most, std::abs(x));
    Looseness out;
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) {  // between phases i and i + 1
        const double a = v[i], b = v[(i + 1) % n];
        out.share.push_back(std::abs(b - a) / (std::abs(a + b) / 2 + 0.05 * most) + 0.01);
        sum += out.share.back();
    }
    for (double& x : out.share) x *= static_cast<double>(n) / sum;
    std::ranges::rotate(
        out.share, out.share.end() - static_cast<std::ptrdiff_t>(c.phase[0] * static_cast<double>(n) + 0.5));
    out.more.resize(n);
    for (const Kink& k : kinks) {
        if (k.longest < std::max(0.08, 5 * frame) + 1e-9) continue;
        for (std::size_t i = 0; i < n; ++i) {
            const double p = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
            if (std::abs(std::remainder(p - k.phase, 1)) < k.longest)
                out.more[i] = shape * shape * jump * jump / (k.longest * period);
        }
    }
    return out;
}

/// How probable intensities of wandering outside the zones are.
struct Wandering {
    std::vector<double> intensities, weights;
    [[nodiscard]] double at(double share) const {
        double sum = 0;
        for (std::size_t i = 0; i < weights.size(); ++i)
            if ((sum += weights[i]) >= share) return intensities[i];
        return intensities.back();
    }
};

Wandering wandering(const Timeline& line, std::span<const Node> nodes, std::span<const Zone> zones) {
    Wandering out;
    // change: in a quarter of a period, in units of the jump
    for (double change = 0.004; change < 4; change *= 1.6) {
        out.intensities.push_back(std::pow(change * line.jump(), 2) / (line.period() / 4));
        out.weights.push_back(line.misfit(nodes, zones, out.intensities.back()));
    }
    const double least = *std::ranges::min_element(out.weights);
    double sum = 0;
    for (double& w : out.weights) sum += w = std::exp((least - w) / 2);
    for (double& w : out.weights) w /= sum;
    return out;
}

}  // namespace

KinkedMotion kinked_motion(std::span<const Folded> folded, std::span<const Kink> kinks, const BaseCycle& base,
                           double v_D, const SmoothedCycle& smoothed, double frames_per_period,
                           double exposure_s) {
    double v_min = std::numeric_limits<double>::infinity(), v_max = -v_min;
    for (const double v : smoothed.cycle.v_mps) {  // fmin and fmax leave NaN out
        v_min = std::fmin(v_min, v);
        v_max = std::fmax(v_max, v);
    }
    const double v_range = v_max > v_min ? v_max - v_min : NAN, scale = smoothed.scale;
    const std::vector<double>& phases = smoothed.cycle.phase;
    const double T = base.period_s();
    double finest = std::numeric_limits<double>::infinity();
    for (const Folded& s : folded) finest = std::min(finest, s.sd_m);
    const Scales scales{T / frames_per_period, finest};
    const double jump = 6 * v_range / T * scales.t_s * scales.t_s / scales.x_m,
                 blur = std::pow(exposure_s / scales.t_s, 2) / 24;
    const double frame = 1 / frames_per_period;
    const Looseness loose = looseness(smoothed.cycle, kinks, jump, T / scales.t_s, frame);
    const Timeline line{base, scales, jump, blur, loose};
    const auto nodes = nodes_of(folded, v_D * T, phases, scale, scales);

    std::vector<Zone> zones;
    for (const Kink& k : kinks) zones.push_back({k.phase, frame / 2, k.rests_after});
    std::vector<Belief> beliefs(kinks.size());
    const auto positions = within(nodes, 0, 1);
    Wandering wander{{std::pow(0.03 * jump, 2) / (line.period() / 4)}, {1}};  // so that kinks have to explain
    for (int sweep = 0; sweep < 2; ++sweep) {
        for (std::size_t k = 0; k < kinks.size(); ++k) {
            const double wide = 8 * frame + kinks[k].longest,
                         reach = sweep == 0 ? kinks[k].reach : std::min(kinks[k].reach, frame);
            const auto window = within(nodes, kinks[k].phase - wide, kinks[k].phase + wide);
            beliefs[k] = search(line, window, zones, k, wander.at(0.75), reach, kinks[k].longest);
        }
        wander = wandering(line, positions, zones);
    }

    constexpr int draws = 16;
    std::vector<double> first(phases.size()), second(phases.size());
    for (int draw = 0; draw < draws; ++draw) {
        for (std::size_t k = 0; k < zones.size(); ++k) {
            const double share = (draw + 0.5) / draws + 0.618 * static_cast<double>(k);
            zones[k] = beliefs[k].at(share - std::floor(share));
        }
        const double share = (draw + 0.5) / draws * 5;
        line.smooth(nodes, zones, wander.at(0.5 + 0.5 * (share - std::floor(share))), first, second);
    }
    KinkedMotion out;
    const double unit = scales.x_m / scales.t_s;
    for (std::size_t i = 0; i < phases.size(); ++i) {
        const double mean = first[i] / draws, variance = second[i] / draws - mean * mean;
        out.v.push_back({mean * unit, std::sqrt(std::max(variance, 0.0)) * unit});
    }
    for (std::size_t k = 0; k < kinks.size(); ++k) {
        const bool rests = kinks[k].rests_after || kinks[(k + kinks.size() - 1) % kinks.size()].rests_after;
        const auto apart = [&](const Belief& b) {
            return std::abs(std::remainder(b.middle - beliefs[k].middle, 1.0)) >
                   2 * (b.middle_sd + beliefs[k].middle_sd);
        };
        const bool alone = std::ranges::count_if(beliefs, apart) + 1 == std::ssize(beliefs);
        if (rests || !alone || beliefs[k].middle_sd > frame / 2) continue;
        constexpr double part = 0.8;  // of a straight change, from 10 to 90 %
        const Belief& b = beliefs[k];
        out.flips.push_back({b.middle - std::floor(b.middle),
                             b.middle_sd,
                             {part * b.length * T, part * b.length_sd * T},
                             part * b.longest * T});
    }
    return out;
}

}  // namespace shaker::reduction
