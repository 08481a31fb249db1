#include "daemon/reduction/drift.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/errors.hpp"

namespace shaker::reduction {
namespace {

constexpr int most_harmonics = 12;  // more would follow noise rather than the kinks

std::vector<Residual> residuals_of(std::span<const MotionSeries> views, const ViewsFit& motion) {
    std::vector<Residual> out;
    std::size_t positions = 0;
    for (const MotionSeries& view : views) positions += view.t_s.size();
    out.reserve(positions);
    const calibration::HarmonicFit& fit = motion.fit;
    for (std::size_t v = 0; v < views.size(); ++v) {
        const MotionSeries& view = views[v];
        std::vector<double> periodic(view.t_s.size());
        fit.periodic(view.t_s, periodic);
        for (std::size_t i = 0; i < view.t_s.size(); ++i) {
            const double t = view.t_s[i];
            const double line = fit.constants[v] + fit.slope.value * (t - fit.origin_s);
            out.push_back({t, view.x_m[i] - line - periodic[i], view.sd_m[i] * motion.scale[v]});
        }
    }
    std::stable_sort(out.begin(), out.end(),
                     [](const Residual& a, const Residual& b) { return a.t_s < b.t_s; });
    return out;
}

std::string percent(double x) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.2f %%", 100 * x);
    return text.data();
}

/// Views with different scales see different drifts of one walker. Half the difference, as an error of both.
double disagreement(std::span<const MotionSeries> views, const calibration::HarmonicSums& sums, double v_D,
                    std::vector<std::string>& notes) {
    if (views.size() < 2) return 0;
    std::size_t lowest = 0, highest = 0;
    std::vector<calibration::Estimate> v;
    for (std::size_t i = 0; i < views.size(); ++i) {
        if (views[i].t_s.size() < 2 * static_cast<std::size_t>(sums.order()) + 4) return 0;
        v.push_back(sums.of_stream(i).fit(sums.order()).slope);
        if (v[i].value < v[lowest].value) lowest = i;
        if (v[i].value > v[highest].value) highest = i;
    }
    const double apart = v[highest].value - v[lowest].value;
    // Least-squares errors for white noise are too small for tracks whose errors depend on the image: 4
    // sigma, not 2.
    if (apart <= 4 * std::hypot(v[highest].sigma, v[lowest].sigma)) return 0;
    if (apart > 0.005 * std::abs(v_D)) {
        notes.push_back("views '" + views[lowest].view + "' and '" + views[highest].view +
                        "' differ in v_D by " + percent(apart / std::max(std::abs(v_D), 1e-12)) +
                        "; half of the difference is included in its error");
    }
    return apart / 2;
}

double rms_claimed(std::span<const MotionSeries> views) {
    double sum = 0, n = 0;
    for (const auto& v : views) {
        for (const double sd : v.sd_m) sum += sd * sd;
        n += static_cast<double>(v.sd_m.size());
    }
    return std::sqrt(sum / n);
}

/// White scatter: within quarters of periods. Contrast: first - second - third + fourth of the quarters'
/// means, which a steady drift cancels from. `unknowns` of the periodic motion lower the scatter within
/// quarters.
ScatterPrior scatter_within(std::span<const Residual> residuals, double start_s, double frequency_hz,
                            int unknowns) {
    struct Quarter {
        double n = 0, w = 0, y = 0, yy = 0;
    };
    double squares = 0, within = 0, freedom = -unknowns, inverse = 0;
    ScatterPrior out;
    for (std::size_t i = 0; i < residuals.size();) {
        const double k = std::floor((residuals[i].t_s - start_s) * frequency_hz);
        std::array<Quarter, 4> q;
        for (; i < residuals.size(); ++i) {
            const double part = ((residuals[i].t_s - start_s) * frequency_hz - k) * 4;
            if (part >= 4) break;
            Quarter& here = q[static_cast<std::size_t>(std::max(part, 0.0))];
            const double y = residuals[i].y_m, w = 1 / (residuals[i].sd_m * residuals[i].sd_m);
            ++here.n;
            here.w += w;
            here.y += w * y;
            here.yy += w * y * y;
        }
        bool whole = true;
        double weight = 0;
        for (Quarter& c : q) {
            whole = whole && c.n > 0;
            if (c.n == 0) continue;
            c.y /= c.w;
            within += std::max(0.0, c.yy - c.w * c.y * c.y);
            freedom += c.n - 1;
            weight += c.w;
        }
        if (!whole) continue;
        const double contrast = (q[0].y - q[1].y - q[2].y + q[3].y) / 4;
        squares += contrast * contrast;
        inverse += 1 / weight;
        ++out.contrasts;
    }
    if (out.contrasts < 2) return out;
    if (freedom > 0) out.white_m = std::sqrt(within / freedom * inverse / out.contrasts);
    // The periodic fit removed the mean of the contrasts: one degree of freedom less.
    out.contrast_m = std::sqrt(squares / (out.contrasts - 1));
    return out;
}

void note_memory(const DriftSpread& spread, std::vector<std::string>& notes) {
    if (spread.independent >= 4) return;
    std::array<char, 256> text{};
    std::snprintf(
        text.data(), text.size(),
        "the record is too short for the memory of the drift (coefficient %.2f a period): it holds %.1f "
        "independent values, 4 are needed; a prior widens v_D's error; measure more periods",
        spread.memory, spread.independent);
    notes.emplace_back(text.data());
}

/// In the words of a note.
std::string velocity(double mps, double sigma_mps) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.4f +- %.4f mm/s", 1e3 * mps, 1e3 * sigma_mps);
    return text.data();
}

}  // namespace

std::vector<PeriodMean> period_means(std::span<const Residual> residuals, double start_s,
                                     double frequency_hz) {
    struct Sums {
        double weight = 0, y = 0, first = 0, last = 0;
        int frames = 0;
    };
    std::vector<PeriodMean> out;
    Sums now;
    int k = -1;
    const auto finish = [&] {
        if (k >= 0 && now.frames > 0) out.push_back({k, now.y / now.weight, now.frames});
        now = {};
    };
    for (const Residual& r : residuals) {
        const double periods = (r.t_s - start_s) * frequency_hz;
        if (periods < 0) continue;
        const int of = static_cast<int>(periods);
        if (of != k) finish();
        k = of;
        const double w = 1 / (r.sd_m * r.sd_m);
        now.weight += w;
        now.y += w * r.y_m;
        ++now.frames;
    }
    finish();
    std::vector<int> counts;
    counts.reserve(out.size());
    for (const auto& m : out) counts.push_back(m.frames);
    if (counts.empty()) return out;
    std::sort(counts.begin(), counts.end());
    const double usual = counts[counts.size() / 2];
    std::erase_if(out, [&](const PeriodMean& m) { return m.frames < 0.9 * usual; });
    return out;
}

Drift measure_drift(std::span<const MotionSeries> walkers, double frequency_hz, double drive_effect_mps,
                    std::vector<std::string>& notes) {
    Drift out;
    const int order = calibration::order_for(frames_per_period(walkers, frequency_hz), most_harmonics);
    const calibration::HarmonicSums sums = sums_of(walkers, frequency_hz, order, calibration::Slope::free);
    out.motion = fit_views(sums, order);
    out.residuals = residuals_of(walkers, out.motion);
    out.residual_m = {out.motion.fit.rms, rms_claimed(walkers)};
    const calibration::Estimate line = out.motion.fit.slope;
    // Periods start at the first frame, so that a record of n whole periods gives n means for any phase of
    // the drive.
    const double start_s = span_of(walkers).from_s;
    const auto means = period_means(out.residuals, start_s, frequency_hz);
    double sigma = 3 * line.sigma;
    if (means.size() < 3) {
        notes.push_back(std::to_string(means.size()) +
                        " whole periods are too few to measure the scatter of the drift; its error is 3 "
                        "times that of the fit");
    } else {
        ScatterPrior prior = scatter_within(out.residuals, start_s, frequency_hz, 2 * order - 3);
        prior.jitter_m = usual_jitter * response_to_friction * std::abs(out.motion.fit.at(1));
        out.spread = drift_spread(means, prior);
        sigma = out.spread.sigma_m * frequency_hz;
        note_memory(out.spread, notes);
    }
    if (const auto& settling = out.spread.settling;
        settling && std::abs(settling->change_m) * frequency_hz > drive_effect_mps) {
        const double settled = line.value + settling->drift_m.value * frequency_hz,
                     settled_sd = settling->drift_m.sigma * frequency_hz;
        const double both = (std::abs(settled - line.value) + 2 * settled_sd) / 2;
        sigma = std::hypot(sigma, std::sqrt(settling->weight) * both);
        if (settling->weight > 0.5) {
            out.settled = {settled, settled_sd};
            notes.push_back("the walker is still settling: D changes by " +
                            percent(settling->change_m * frequency_hz / line.value) +
                            " over the run; v_D is its mean, the settled value is " +
                            velocity(settled, settled_sd) + "; v_D's error includes both");
        }
    }
    out.v_D = {line.value, std::hypot(sigma, disagreement(walkers, sums, line.value, notes))};
    return out;
}

}  // namespace shaker::reduction
