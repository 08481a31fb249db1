#pragma once
// Identification: measures the response of the base to a multisine at the drive's harmonics, at two or
// more levels.
#include <array>
#include <complex>
#include <string>
#include <vector>

#include "calibration/accelerometer/transverse.hpp"
#include "daemon/control/harmonic_estimator.hpp"
#include "drivers/drive.hpp"

namespace shaker::control {

struct IdentificationSettings {
    int harmonics = 8;
    double gamma = paper_g;  // m/s^2, of the later run; the levels are shares of it
    double volts_limit = 1;  // V, peak at the DAC
    int settle = 25;         // windows to wait after a change
    int average = 20;        // windows averaged per level
    std::array<std::complex<double>, max_harmonics> nominal{};  // response of the data sheet, m/s^2 per V
};

/// Result at one level of the drive. Lists are in order of increasing level.
struct IdentifiedLevel {
    double peak_V = 0, peak_mps2 = 0;                     // peaks of drive and motion over a period
    std::array<std::complex<double>, max_harmonics> h{};  // m/s^2 per V
    std::array<double, max_harmonics> sd{};               // m/s^2 per V, of the real or imaginary part of h
    std::array<double, max_harmonics>
        coherence{};                            // 0..1, share of the motion's power explained by the drive
    std::array<double, max_harmonics> floor{};  // m/s^2, scatter of a window's amplitude
};

/// Response of the base at f, 2f, ...
struct IdentifiedResponse {
    int harmonics = 0;
    double frequency = 0;                                 // Hz
    std::array<std::complex<double>, max_harmonics> h{};  // m/s^2 per V, at the highest level
    /// In m/s^2 per V, of the real or imaginary part of h, from the scatter of the windows.
    std::array<double, max_harmonics> sd{};
    std::array<double, max_harmonics>
        coherence{};                            // 0..1, share of the motion's power explained by the drive
    std::array<double, max_harmonics> floor{};  // m/s^2, scatter of a window's amplitude
    std::array<std::complex<double>, max_harmonics> below{};  // h at the second highest level
    double level = 0;                                         // m/s^2, peak acceleration at the highest level
    bool nonlinear = false;  // h and below differ by more than 10 % or 10 degrees at a harmonic
    double gain = 1;         // rms of h / rms of the data sheet's response
    /// Phase of h relative to the data sheet at harmonic 1, rad. More than 90 degrees: a connection
    /// is reversed.
    double turn = 0;
    std::array<double, 3> axis{};  // shaker axis in sensor axes, mean over the windows of the highest level
    /// Motion across the axis, at the highest level.
    std::array<calibration::Transverse, max_harmonics> across{};
    std::vector<IdentifiedLevel> levels;
    [[nodiscard]] bool polarity_doubtful() const { return std::abs(turn) > 0.25 * two_pi; }
};

/// State machine: processes windows, sets the drive to play; starts with volts().
class Identification {
public:
    explicit Identification(const IdentificationSettings& settings);
    [[nodiscard]] const Harmonics<Voltage>& volts() const noexcept { return volts_; }
    /// Processes a window during which the newest drive was in force unchanged. True when volts()
    /// changed or identification is done.
    bool take(const PeriodEstimate& window);
    [[nodiscard]] bool done() const noexcept { return done_; }
    /// The response up to the last completed level.
    [[nodiscard]] const IdentifiedResponse& response() const noexcept { return found_; }

private:
    void conclude_level();
    void conclude_across(const Harmonics<Acceleration>& mean);

    IdentificationSettings settings_;
    Harmonics<Voltage> volts_;
    std::vector<PeriodEstimate> windows_;  // of the present level
    int settled_ = 0, level_ = 0;
    bool done_ = false;
    IdentifiedResponse found_;
};

/// Findings for the operator, one sentence each.
std::vector<std::string> findings(const IdentifiedResponse& response);

}  // namespace shaker::control
