#pragma once
// PredictedMotion: the acceleration that the sensor should show at a sample, from the drive and the
// shaker's response. Real-time.
#include <array>
#include <complex>
#include <cstddef>
#include <optional>

#include "drivers/drive.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/time.hpp"

namespace shaker::safety {

/// The identified plant and the clock map, from the control thread to the thread that reads the
/// accelerometer.
struct Expectation {
    /// m/s^2 per V at f, 2f, ... along `axis`, as the sensor shows it under the clock map below: the
    /// sensor's delay and low-pass are in the phases. Best: measured harmonics / harmonics of the
    /// drive.
    std::array<std::complex<double>, max_harmonics> response{};
    double frequency = 20;         // Hz, frequency at which `response` holds
    std::array<double, 3> axis{};  // shaker axis in sensor axes, unit vector; all 0: unknown
    AccelTick at{};                // clock map: the accelerometer sample that was taken ...
    double dac_sample = 0;         // ... when this DAC sample left the converter, and
    double dac_per_tick = 12;      // DAC samples per accelerometer sample
    double sigma = 0;              // noise of one accelerometer sample, m/s^2
    /// Largest residual, rms over a quarter of a period, as a share of the predicted rms. Infinite:
    /// the residual is not checked.
    double tolerance = 0.3;
    double disturbance = 0.5;  // m/s^2 rms, added to the limit: friction of a walker, a hand
    double settling_s = 0.05;  // s, time constant with which the base follows a change of the drive
};

/// Prediction in steady state: a(t) = Im sum_q H_q V_q e^{i q theta(t)}, with H the response (m/s^2 per V), V
/// the harmonics of the drive (V) and theta the drive's phase at the DAC sample of the clock map.
/// Ramps and soft stops: amplitudes and frequency follow the raised cosine of the synthesiser.
/// Slack, a bound of the transient: decays with settling_s from at most 1.5 times the change of amplitude (8
/// times the motion while the frequency is ramped).
/// Sign: as AccelerometerInfo::acceleration along `axis`, without gravity and offset.
class PredictedMotion {
public:
    /// rate_hz: accelerometer. frequency: Hz, of the synthesiser's silent start. dac_rate_hz: DAC.
    PredictedMotion(double rate_hz, double frequency, double dac_rate_hz) noexcept
        : rate_hz_{rate_hz},
          to_{.volts = {}, .frequency = frequency, .step = frequency / dac_rate_hz},
          frequency_{frequency} {}

    /// Sets response and clock map. A response at the frequency that is playing takes effect at once;
    /// one at another frequency waits for the change to that frequency.
    void expect(const Expectation& expectation) noexcept;
    /// A change of the drive, in order, before it leaves the converter. Silence after an underrun
    /// takes effect at once and invalidates older clock maps.
    void hear(const DriveChange& change) noexcept;

    struct Sample {
        double value = 0;  // m/s^2 along the axis
        double rms = 0;    // m/s^2, rms over a period at the present amplitudes
        double slack = 0;  // m/s^2 rms, bound of the transient after a change; far above the motion while the
                           // frequency changes
    };
    /// The prediction at a tick; ticks must not decrease. Empty while clock map or response is
    /// unknown, and from a trip's stop until the next change.
    std::optional<Sample> at(AccelTick tick) noexcept;
    /// DAC sample that was playing at a tick; empty while the clock map is unknown.
    [[nodiscard]] std::optional<double> dac_sample(AccelTick tick) const noexcept;
    /// Frequency of the drive in force, Hz; without a clock map that of the newest change.
    [[nodiscard]] double frequency() const noexcept { return frequency_; }
    /// The newest expectation. Requires that at() has returned a sample.
    [[nodiscard]] const Expectation& expectation() const noexcept { return *newest_; }

private:
    using Amplitudes = std::array<std::complex<double>, max_harmonics>;
    /// The drive at one end of a ramp and the base's motion for it.
    struct End {
        Harmonics<Voltage> volts;
        double frequency = 0;
        Amplitudes motion{};
        double step = 0;  // turns per DAC sample
        bool known = true;
    };
    static constexpr std::size_t most_waiting = 16;

    void begin(const DriveChange& change) noexcept;
    void predict(End& end) const noexcept;
    void weigh() noexcept;
    /// Slack x DAC samples after the start of the newest change.
    [[nodiscard]] double slack_at(double x) const noexcept;
    /// Slack x DAC samples after the start of a soft stop; rms: of the motion without the stop, m/s^2.
    [[nodiscard]] double fade_slack(double x, double rms) const noexcept;

    double rate_hz_;
    std::optional<Expectation> newest_, before_;  // before_: the newest at another frequency
    bool mapped_ = false, stopped_ = false, sweeps_ = false;
    std::array<DriveChange, most_waiting> waiting_{};
    std::size_t first_waiting_ = 0, waiting_count_ = 0;
    End from_, to_;
    double first_ = 0, ramp_ = 0;  // DAC samples
    double held_ = 0;              // DAC samples after first_ from which the volts of the ramp stand still
    double fade_first_ = 0, fade_ = 0;  // DAC samples: the soft stop of this drive; fade_ 0: none
    double map_from_ = 0;               // DAC sample; clock maps from before it are invalid
    double phase_ = 0;                  // turns at first_
    double change_rms_ = 0;             // m/s^2, rms of to_ minus from_
    double left_ = 0;                   // m/s^2, slack at first_ from earlier changes
    int order_ = 0;
    double frequency_;
};

}  // namespace shaker::safety
