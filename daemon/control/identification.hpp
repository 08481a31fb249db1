#pragma once
// Finds out how the base answers to the drive: a multisine at the harmonics, at two levels or more.
#include <array>
#include <complex>
#include <string>
#include <vector>

#include "calibration/transverse.hpp"
#include "daemon/control/harmonic_estimator.hpp"
#include "drivers/drive.hpp"

namespace shaker {

struct IdentificationSettings {
    int harmonics = 8;
    double gamma = paper_g;  // of the run to come: the levels are shares of it
    double volts_limit = 1;  // peak at the DAC
    int settle = 25;         // windows after a change
    int average = 20;        // windows a level
    std::array<std::complex<double>, max_harmonics> nominal{};  // data sheet, m/s^2 a volt
};

/// What one level of the drive showed, lowest first in a list of them.
struct IdentifiedLevel {
    double peak_V = 0, peak_mps2 = 0;                     // of drive and motion over a period
    std::array<std::complex<double>, max_harmonics> h{};  // m/s^2 a volt
    std::array<double, max_harmonics> sd{};               // of each part of h
    std::array<double, max_harmonics> coherence{};        // 0..1
    std::array<double, max_harmonics> floor{};            // m/s^2
};

/// How the base answers at f, 2f, ...
struct IdentifiedResponse {
    int harmonics = 0;
    double frequency = 0;                                 // Hz
    std::array<std::complex<double>, max_harmonics> h{};  // m/s^2 a volt, at the highest level
    std::array<double, max_harmonics> sd{};         // of each part of h, from the scatter of the windows
    std::array<double, max_harmonics> coherence{};  // 0..1: share of the motion that the drive explains
    std::array<double, max_harmonics> floor{};      // m/s^2, scatter of a window's amplitude
    std::array<std::complex<double>, max_harmonics> below{};  // h at the level before
    double level = 0;                                         // peak acceleration at the highest level, m/s^2
    bool nonlinear = false;  // the two differ by more than 10 % or 10 degrees at a harmonic
    double gain = 1;         // rms of h against the data sheet's
    /// Phase of h against the data sheet's at harmonic 1, rad: beyond 90 degrees something is connected the
    /// wrong way round.
    double turn = 0;
    std::array<double, 3> axis{};  // the shaker's, in sensor axes, mean of the highest level
    std::array<Transverse, max_harmonics> across{};  // motion beside it, at the highest level
    std::vector<IdentifiedLevel> levels;
    [[nodiscard]] bool polarity_doubtful() const { return std::abs(turn) > 0.25 * two_pi; }
};

/// Hears of windows and says what to play; begins with volts().
class Identification {
public:
    explicit Identification(const IdentificationSettings& settings);
    [[nodiscard]] const Harmonics<Voltage>& volts() const noexcept { return volts_; }
    /// A window of the newest drive, unchanged all through. True when volts() changed or it is done.
    bool take(const PeriodEstimate& window);
    [[nodiscard]] bool done() const noexcept { return done_; }
    /// Of the newest level that was concluded.
    [[nodiscard]] const IdentifiedResponse& response() const noexcept { return found_; }

private:
    void conclude_level();
    void conclude_across(const Harmonics<Acceleration>& mean);

    IdentificationSettings settings_;
    Harmonics<Voltage> volts_;
    std::vector<PeriodEstimate> windows_;  // of this level
    int settled_ = 0, level_ = 0;
    bool done_ = false;
    IdentifiedResponse found_;
};

/// What an operator should know of it; one sentence each.
std::vector<std::string> findings(const IdentifiedResponse& response);

}  // namespace shaker
