#include "daemon/control/identification.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "daemon/control/equaliser.hpp"

namespace shaker::control {

namespace {
constexpr double first_level = 0.1;  // peak acceleration of the first level by the data sheet, share of gamma
constexpr double first_volts = 0.05;  // largest peak of the first level, share of the voltage limit
constexpr double raise = 3;           // factor between levels
constexpr double enough = 0.25;       // share of gamma; no level starts above it
constexpr double stuck = 0.3;         // share of the data sheet's response; below it the base may still stick
constexpr int most_levels = 5;
constexpr double same_gain = 0.1, same_phase = two_pi / 36;
}  // namespace

Identification::Identification(const IdentificationSettings& settings) : settings_{settings} {
    const int k = settings_.harmonics;
    Harmonics<Acceleration> flat;
    for (int q = 1; q <= k; ++q)  // Schroeder's phases, for a low peak
        flat.at(q) = std::polar(1.0, -0.5 * two_pi * q * (q - 1) / k);
    double largest = 0;
    for (int i = 0; i < 1024; ++i) largest = std::max(largest, std::abs(value_at(flat, two_pi * i / 1024)));
    for (int q = 1; q <= k; ++q)
        volts_.at(q) = first_level * settings_.gamma / largest * flat.at(q) /
                       settings_.nominal[static_cast<std::size_t>(q - 1)];
    const double share = peak(volts_) / (first_volts * settings_.volts_limit);
    if (share > 1)
        for (auto& v : volts_.a) v /= share;
    found_.harmonics = k;
}

bool Identification::take(const PeriodEstimate& window) {
    if (done_ || ++settled_ <= settings_.settle) return false;
    windows_.push_back(window);
    if (static_cast<int>(windows_.size()) < settings_.average) return false;
    conclude_level();
    settled_ = 0;
    windows_.clear();
    return true;
}

void Identification::conclude_level() {
    const auto n = static_cast<double>(windows_.size());
    found_.below = found_.h;
    Harmonics<Acceleration> mean;
    bool changed = level_ == 0;
    double answer = 0, sheet = 0;
    for (int q = 1; q <= settings_.harmonics; ++q) {
        const auto i = static_cast<std::size_t>(q - 1);
        for (const auto& w : windows_) mean.at(q) += w.along.at(q) / n;
        double scatter = 0;
        for (const auto& w : windows_) scatter += std::norm(w.along.at(q) - mean.at(q)) / (n - 1);
        found_.h[i] = mean.at(q) / volts_.at(q);
        found_.floor[i] = std::sqrt(scatter);
        found_.sd[i] = std::sqrt(0.5 * scatter / n) / std::abs(volts_.at(q));
        found_.coherence[i] = std::norm(mean.at(q)) / (std::norm(mean.at(q)) + scatter);
        answer += std::norm(found_.h[i]);
        sheet += std::norm(settings_.nominal[i]);
        if (level_ == 0) continue;
        const std::complex<double> ratio = found_.h[i] / found_.below[i];
        const double doubt = 3 * found_.sd[i] / std::abs(found_.h[i]);
        changed = changed || std::abs(std::abs(ratio) - 1) > same_gain + raise * doubt ||
                  std::abs(std::arg(ratio)) > same_phase + raise * doubt;
    }
    found_.nonlinear = level_ > 0 && changed;
    found_.turn = std::arg(found_.h[0] / settings_.nominal[0]);
    found_.level = 0;
    for (int i = 0; i < 512; ++i)
        found_.level = std::max(found_.level, std::abs(value_at(mean, two_pi * i / 512)));
    found_.levels.push_back(
        {peak(volts_), found_.level, found_.h, found_.sd, found_.coherence, found_.floor});
    conclude_across(mean);
    ++level_;
    const double next_peak = raise * peak(volts_);
    found_.gain = std::sqrt(answer / sheet);
    const bool loose = found_.gain > stuck;
    done_ = (level_ >= 2 && ((!changed && loose) || found_.level > enough * settings_.gamma)) ||
            level_ == most_levels || next_peak > settings_.volts_limit;
    if (!done_)
        for (auto& v : volts_.a) v *= raise;
}

// In sensor axes: each window may have a slightly different axis.
void Identification::conclude_across(const Harmonics<Acceleration>& mean) {
    const auto n = static_cast<double>(windows_.size());
    found_.axis = {};
    for (const PeriodEstimate& w : windows_)
        for (std::size_t k = 0; k < 3; ++k) found_.axis[k] += w.axis[k] / n;
    const auto beside = calibration::across_axes(found_.axis);
    const auto on = [&](const PeriodEstimate& w, std::size_t to, int q) {
        const auto own = calibration::across_axes(w.axis);
        std::complex<double> sum = 0;
        for (std::size_t k = 0; k < 3; ++k)
            sum += beside[to][k] * (w.axis[k] * w.along.at(q) + own[0][k] * w.across[0].at(q) +
                                    own[1][k] * w.across[1].at(q));
        return sum;
    };
    for (int q = 1; q <= settings_.harmonics; ++q) {
        std::array<std::complex<double>, 2> across{};
        double scatter = 0;
        for (std::size_t to = 0; to < 2; ++to) {
            const double before = scatter;
            for (const PeriodEstimate& w : windows_) across[to] += on(w, to, q) / n;
            for (const PeriodEstimate& w : windows_) scatter += std::norm(on(w, to, q) - across[to]);
            // Not even noise: the sensor has no such axis.
            if (!(scatter - before > 1e-24 * std::norm(mean.at(q)))) scatter = NAN;
        }
        found_.across[static_cast<std::size_t>(q - 1)] =
            calibration::transverse(mean.at(q), across, found_.axis, std::sqrt(scatter / 4 / (n - 1) / n));
    }
}

std::vector<std::string> findings(const IdentifiedResponse& r) {
    std::vector<std::string> sentences;
    if (r.polarity_doubtful())
        sentences.push_back(fmt::format(
            "the base answers {:+.0f} degrees from the data sheet at harmonic 1: is the shaker, the "
            "amplifier or the sensor connected the wrong way round?",
            r.turn * 360 / two_pi));
    if (r.gain > 2 || r.gain < 0.5)
        sentences.push_back(
            fmt::format("the base answers {:.2f} times as strongly as the data sheet says: are the "
                        "amplifier's gain, full_scale_V and the masses right?",
                        r.gain));
    for (int q = 1; q <= r.harmonics; ++q) {
        const auto i = static_cast<std::size_t>(q - 1);
        if (r.coherence[i] < 0.95)
            sentences.push_back(fmt::format(
                "harmonic {} ({:.1f} Hz): coherence {:.2f}, the drive hardly moves the base there", q,
                q * r.frequency, r.coherence[i]));
        if (!r.nonlinear || r.below[i] == 0.0) continue;
        const std::complex<double> ratio = r.h[i] / r.below[i];
        if (std::abs(std::abs(ratio) - 1) > same_gain || std::abs(std::arg(ratio)) > same_phase)
            sentences.push_back(
                fmt::format("harmonic {}: the response changed by a factor of {:.2f} and {:+.0f} degrees "
                            "when the drive was tripled: friction, a stiffening spring or the walker",
                            q, std::abs(ratio), std::arg(ratio) * 360 / two_pi));
    }
    return sentences;
}

}  // namespace shaker::control
