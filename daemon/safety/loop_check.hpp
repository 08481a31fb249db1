#pragma once
// LoopCheck: ten periods at a low level before a drive from rest, compared with the response in use.
#include <array>
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/control/identification.hpp"
#include "daemon/safety/trip.hpp"
#include "drivers/drive.hpp"

namespace shaker::safety {

/// The drive and the state of the bench before the check.
struct LoopCheckPlan {
    Harmonics<Acceleration> target;  // of the drive that follows
    /// The response in use, m/s^2 per V at f, 2f, ...
    std::array<std::complex<double>, max_harmonics> response{};
    /// Levels of the identification behind the response; null: the response is the data sheet's.
    const control::IdentifiedResponse* identified = nullptr;
    double noise = 0;             // m/s^2, sd of one part of an amplitude in a window with the drive off
    bool direction_known = true;  // false: the sign of the sensor's axis is unknown
    bool gain_shown = true;       // false: neither gravity nor a camera shows the gain of the sensor
};

/// The drive of the check is the target's waveform at 5 % of its level, at least 10 times the noise, at most
/// 0.5 m/s^2 peak (below the walker's threshold) and never above the target. A base that sticks at low levels
/// is checked at the lowest level at which the identification found it free.
///
/// r is the measured motion over the expected one by least squares over the driven harmonics, as a mean of
/// the windows. Noise: |r| < 0.02, or r is not 3 times its own error, or that error exceeds 0.2. Polarity:
/// the real part of r is negative. Gain: |r| outside 0.6 to 1.6 (1/4 to 4 for the data sheet's response; 0.8
/// to 1.25 for either when nothing else shows the sensor's gain).
class LoopCheck {
public:
    static constexpr int periods = 10;

    explicit LoopCheck(const LoopCheckPlan& plan);

    /// Drive of the check, V.
    [[nodiscard]] const Harmonics<Voltage>& volts() const noexcept { return volts_; }
    /// Processes a window during which volts() was in force unchanged. True when ten periods are complete.
    bool take(const Harmonics<Acceleration>& measured, int window_periods);
    /// After the last window: empty when the bench agrees with the response. `tick` is not set.
    [[nodiscard]] std::optional<Trip> trip() const;
    /// One sentence: the finding, with the values and the allowed range.
    [[nodiscard]] std::string finding() const;

private:
    enum class Verdict { agrees, noise, polarity, gain };
    [[nodiscard]] Verdict verdict() const;
    [[nodiscard]] std::complex<double> ratio() const;
    [[nodiscard]] double error() const;

    Harmonics<Voltage> volts_;
    Harmonics<Acceleration> expected_;
    double least_gain_, most_gain_;
    bool direction_known_;
    std::vector<std::complex<double>> ratios_;  // one a window
    int taken_ = 0;                             // periods
};

}  // namespace shaker::safety
