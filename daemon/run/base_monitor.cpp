#include "daemon/run/base_monitor.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <boost/math/special_functions/sinc.hpp>
#include <cmath>
#include <numbers>
#include <utility>

#include "calibration/harmonics/harmonic_fit.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker::run {

namespace {

constexpr double least_ratio = 0.8, most_ratio = 1.25;
constexpr double errors = 3;         // by which a verdict is outside
constexpr double most_error = 0.1;   // of a ratio of 1
constexpr int patience = 20;         // windows
constexpr int in_a_row = 2;          // windows outside
constexpr std::size_t few = 10;      // positions
constexpr int most_harmonics = 4;    // of the base's position: more are below the noise
constexpr double least_share = 0.5;  // of the frames of a window

bool of_base(const acquisition::TargetTrack& t) { return t.target.name == "base" && !t.tracks.empty(); }

/// Positions at known times from from_s to to_s; to_s: not included.
struct Positions {
    std::vector<double> t_s, x_m, sd_m;
    std::size_t frames = 0;  // with and without a position
};
Positions positions(const acquisition::TargetTrack& base, double from_s, double to_s) {
    Positions p;
    for (auto t = base.tracks.rbegin(); t != base.tracks.rend(); ++t) {
        const double at_s = seconds(t->time);
        if (at_s < from_s) break;
        if (!(at_s < to_s)) continue;  // not known yet, or later
        ++p.frames;
        using tracking::TrackState;
        constexpr double whole_px = 0.1;  // clipped edges of a target that is seen whole are off by less
        const bool clipped = t->fix.state == TrackState::clipped && t->fix.sd_px < whole_px;
        if (t->fix.state != TrackState::ok && !clipped) continue;
        p.t_s.push_back(at_s);
        p.x_m.push_back(t->x_m);
        p.sd_m.push_back(t->sd_m);
    }
    std::ranges::reverse(p.t_s);
    std::ranges::reverse(p.x_m);
    std::ranges::reverse(p.sd_m);
    return p;
}

// Half of the positions or more stay for the residuals. Their few may be small in one window: the noise is at
// least that of the tracker.
std::optional<calibration::HarmonicFit> fit_of(const Positions& p, double frequency) try {
    const auto n = static_cast<int>(p.t_s.size());
    const double rate = (n - 1) / (p.t_s.back() - p.t_s.front());
    const int order =
        std::min(calibration::order_for(rate / frequency, most_harmonics), std::max(2, (n / 2 - 1) / 2));
    auto fit = calibration::fit_harmonics(std::vector{calibration::HarmonicSamples{p.t_s, p.x_m, p.sd_m}},
                                          frequency, std::max(2, order), calibration::Slope::none);
    const double least = std::max(1.0, 1 / (fit.scale * fit.scale));
    for (double& c : fit.covariance) c *= least;
    return fit;
} catch (const InputError&) {
    return std::nullopt;  // too few, or at the same phases of each period
}

BaseFinding contradiction(const std::string& camera, const BaseComparison& c, bool low, bool high) {
    if (low || high)
        return {fmt::format(
                    "the base moves {:.3f} +- {:.3f} times as far by camera \"{}\" as by the accelerometer",
                    c.ratio.value, c.ratio.sigma, camera),
                safety::Trip{.cause = safety::Cause::base_motion,
                             .value = c.ratio.value,
                             .limit = low ? least_ratio : most_ratio}};
    return {
        fmt::format("the base moves to the other side by camera \"{}\" than by the accelerometer ({:.2f} +- "
                    "{:.2f} rad): check `along` of the camera and shaker_axis of the sensor; \"fit\" takes "
                    "the largest component as positive",
                    camera, c.turn.value, c.turn.sigma),
        safety::Trip{.cause = safety::Cause::polarity, .value = std::cos(c.turn.value)}};
}

}  // namespace

BaseComparison compare(const acquisition::TargetTrack& base, const control::PeriodWindows::Window& window,
                       const control::DriveHistory& drive) {
    BaseComparison c{.ratio = {NAN, NAN}, .turn = {NAN, NAN}};
    const Positions p = positions(base, window.from_s, window.to_s);
    if (p.t_s.size() < 2 || static_cast<double>(p.t_s.size()) < least_share * static_cast<double>(p.frames))
        return c;
    const double f = drive.frequency();
    const auto fit = fit_of(p, f);
    if (!fit) return c;
    // The window's phases are those of the drive, the fit's those of its own origin.
    const double turns = drive.turns(fit->origin_s);
    std::array<std::complex<double>, 2> r;
    std::array<double, 2> relative{};
    for (int q = 1; q <= 2; ++q) {
        const auto i = static_cast<std::size_t>(q - 1);
        const double qw = q * two_pi * f;
        const std::complex<double> a = window.estimate.along.at(q);
        r[i] = -qw * qw * fit->at(q) * std::polar(1.0, -two_pi * q * std::fmod(turns, 1)) /
               (a * boost::math::sinc_pi(std::numbers::pi * q * f * base.exposure_s));
        const double of_camera = fit->amplitude_sd(q) / std::abs(fit->at(q)),
                     of_sensor = window.estimate.sd / std::abs(a),
                     sigma = std::abs(r[i]) * std::hypot(of_camera, of_sensor);
        relative[i] = sigma / std::abs(r[i]);
        if (of_sensor < 1 && !(c.ratio.sigma <= sigma)) c.ratio = {std::abs(r[i]), sigma};
    }
    if (relative[0] < 1 && relative[1] < 1)
        c.turn = {std::arg(r[0] * r[0] / r[1]), std::hypot(2 * relative[0], relative[1])};
    return c;
}

std::optional<BaseFinding> BaseMonitor::watch(const acquisition::Streams& streams, double frequency,
                                              double limit_m) {
    seen_.resize(streams.tracks.size());
    std::optional<BaseFinding> farthest;
    for (std::size_t i = 0; i < streams.tracks.size(); ++i) {
        const acquisition::TargetTrack& base = streams.tracks[i];
        const std::size_t taken = base.dropped + base.tracks.size();
        if (!of_base(base) || std::exchange(seen_[i], taken) == taken) continue;
        Positions p = positions(base, seconds(base.tracks.back().time) - 1 / frequency, INFINITY);
        std::vector<double>& x = p.x_m;
        if (x.size() < 2) continue;
        std::ranges::sort(x);
        const std::size_t out = x.size() < few ? 0 : 1;
        const double noise_m = errors * *std::ranges::max_element(p.sd_m),
                     m = 0.5 * (x[x.size() - 1 - out] - x[out]) - noise_m;
        if (!(m > limit_m) || (farthest && farthest->trip->value >= m)) continue;
        farthest = BaseFinding{
            fmt::format("camera \"{}\" sees the base move {:.3f} mm from its mean position (limit {:.3f} mm)",
                        base.camera, 1e3 * m, 1e3 * limit_m),
            safety::Trip{.cause = safety::Cause::displacement,
                         .stop = safety::StopKind::hard,
                         .value = m,
                         .limit = limit_m}};
    }
    return farthest;
}

std::vector<BaseFinding> BaseMonitor::judge(const acquisition::Streams& streams,
                                            const control::PeriodWindows::Window& window,
                                            const control::DriveHistory& drive, bool counts) {
    std::vector<BaseFinding> findings;
    tracks_.resize(streams.tracks.size());
    if (windows_ > patience) return findings;
    if (counts) ++windows_;
    for (std::size_t i = 0; i < streams.tracks.size(); ++i) {
        const acquisition::TargetTrack& base = streams.tracks[i];
        Judged& before = tracks_[i];
        if (!of_base(base) || before.right) continue;
        const BaseComparison c = compare(base, window, drive);
        const calibration::Estimate &ratio = c.ratio, &turn = c.turn;
        if (!(ratio.sigma < most_error * std::max(1.0, ratio.value))) {
            if (windows_ > patience)
                findings.push_back({fmt::format(
                    "camera \"{}\" does not show whether the accelerometer is right: {}", base.camera,
                    std::isfinite(ratio.sigma)
                        ? fmt::format("the error of their ratio is {:.0f} %", 100 * ratio.sigma)
                        : "the base's motion cannot be fitted to its pictures")});
            continue;
        }
        const bool low = ratio.value<least_ratio - errors * ratio.sigma, high = ratio.value> most_ratio +
                         errors * ratio.sigma,
                   against = std::abs(turn.value) > std::numbers::pi / 2 + errors * turn.sigma;
        before.wrong = low || high || against ? before.wrong + 1 : 0;
        // The sign needs both harmonics. A stop is found again until it has come.
        before.right = ratio.value > least_ratio + errors * ratio.sigma &&
                       ratio.value < most_ratio - errors * ratio.sigma && !against &&
                       std::isfinite(turn.sigma);
        if (before.wrong >= in_a_row) findings.push_back(contradiction(base.camera, c, low, high));
    }
    return findings;
}

}  // namespace shaker::run
