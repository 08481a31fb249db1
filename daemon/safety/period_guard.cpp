#include "daemon/safety/period_guard.hpp"

#include <algorithm>

namespace shaker::safety {

namespace {
constexpr double equal_samples = 1e-9;  // m/s^2, sd: a working sensor has more noise
constexpr double clear_of_noise = 30;   // sd; a smaller motion is not checked
constexpr double most_drive = 4;        // times the drive that the response requires
constexpr double divergence = 0.5;      // of the target
constexpr double band_db = 3, band_warn_db = 1;
constexpr int off_windows = 2;
constexpr double least_harmonic = 0.1;  // of the target; smaller harmonics may be off by more without harm
constexpr double least_coherence = 0.5;

double across(const control::PeriodEstimate& e, int q) {
    return std::sqrt(std::norm(e.across[0].at(q)) + std::norm(e.across[1].at(q)));
}

bool finite(const control::PeriodWindow& m) {
    return std::isfinite(m.sd) &&
           std::ranges::all_of(m.measured.a, [](const auto& a) { return std::isfinite(std::abs(a)); });
}

Trip trip(std::int64_t tick, Cause cause, double value, double limit, int q = 0,
          StopKind stop = StopKind::soft) {
    return {.cause = cause,
            .stop = stop,
            .on_dac_clock = true,
            .harmonic = q,
            .value = value,
            .limit = limit,
            .tick = tick};
}

}  // namespace

std::optional<Trip> PeriodGuard::check(const JudgedWindow& w, Warnings& warnings) {
    if (!finite(w.motion)) {
        if (on(Cause::sensor_not_finite)) return trip(w.tick, Cause::sensor_not_finite, NAN, 0);
        return std::nullopt;
    }
    Harmonics<Acceleration> must;
    double drive = 0, asked = 0;
    for (int q = 1; q <= max_harmonics; ++q) {
        const std::complex<double> h = w.response[static_cast<std::size_t>(q - 1)];
        must.at(q) = h * w.motion.volts.at(q);
        drive += std::norm(must.at(q));
        asked += std::norm(w.target.at(q));
    }
    const double expected = control::norm(must, max_harmonics),
                 seen = control::norm(w.motion.measured, max_harmonics);
    const double floor = clear_of_noise * w.noise * std::sqrt(2.0 * max_harmonics);
    const bool equal = w.motion.sd < equal_samples;
    if (expected > floor && (w.noise > 0 || equal) && seen < least_seen * expected) {
        if (equal && on(Cause::sensor_frozen)) {
            const double period = static_cast<double>(w.estimate.samples) / w.estimate.periods;
            return trip(w.tick, Cause::sensor_frozen, w.estimate.samples, 0.25 * period);
        }
        if (!equal && on(Cause::sensor_open))
            return trip(w.tick, Cause::sensor_open, seen / expected, least_seen);
    }
    for (int q = 1; q <= 2; ++q) {
        const double along = std::abs(w.motion.measured.at(q)), beside = across(w.estimate, q);
        if (!(std::max(along, beside) > floor) || w.noise <= 0) continue;
        const double share = beside / std::max(along, 1e-3 * beside);
        if (share > limits_.transverse.abort && on(Cause::transverse))
            return trip(w.tick, Cause::transverse, share, limits_.transverse.abort, q);
        if (share > limits_.transverse.warn) warnings.count(Cause::transverse);
    }
    if (w.followed && asked > 0 && std::sqrt(drive) > most_drive * std::sqrt(asked) && on(Cause::gain_limit))
        return trip(w.tick, Cause::gain_limit, std::sqrt(drive / asked), most_drive, 0, StopKind::hard);
    return w.followed && asked > 0 ? judge_target(w, warnings) : std::nullopt;
}

std::optional<Trip> PeriodGuard::judge_target(const JudgedWindow& w, Warnings& warnings) {
    if (w.report.mode == control::Equaliser::Mode::failed && on(Cause::loop_divergence))
        return trip(w.tick, Cause::loop_divergence, w.report.error, divergence);
    if (w.report.locked) near_ = true;
    if (!near_) return std::nullopt;
    if (w.report.error > divergence && on(Cause::loop_divergence))
        return trip(w.tick, Cause::loop_divergence, w.report.error, divergence);
    const double all = control::norm(w.target, max_harmonics) * w.report.reached;
    double worst = 0;
    int which = 0;
    for (int q = 1; q <= max_harmonics; ++q) {
        const double wanted = std::abs(w.target.at(q)) * w.report.reached;
        if (!(wanted > std::max(clear_of_noise * w.noise, least_harmonic * all))) continue;
        const double off = std::abs(20 * std::log10(std::abs(w.motion.measured.at(q)) / wanted));
        if (off > worst) worst = off, which = q;
    }
    if (worst > band_warn_db) warnings.count(Cause::harmonic_band);
    off_ = worst > band_db ? off_ + 1 : 0;
    if (off_ >= off_windows && on(Cause::harmonic_band))
        return trip(w.tick, Cause::harmonic_band, worst, band_db, which);
    return std::nullopt;
}

std::optional<Trip> PeriodGuard::check(const control::IdentifiedResponse& r, bool axis_known, bool ended,
                                       std::int64_t tick) const {
    const double best =
        *std::max_element(r.coherence.begin(), r.coherence.begin() + std::max(r.harmonics, 1));
    if (!(best >= least_coherence) && on(Cause::sensor_open))
        return trip(tick, Cause::sensor_open, best, least_coherence, 1);
    if ((r.gain > most_sheet_gain || (ended && r.gain < 1 / most_sheet_gain)) && on(Cause::gain_limit))
        return trip(tick, Cause::gain_limit, r.gain, r.gain > 1 ? most_sheet_gain : 1 / most_sheet_gain, 1);
    if (axis_known && r.polarity_doubtful() && on(Cause::polarity))
        return trip(tick, Cause::polarity, std::cos(r.turn), 0, 1);
    return std::nullopt;
}

}  // namespace shaker::safety
