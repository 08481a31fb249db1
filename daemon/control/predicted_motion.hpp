#pragma once
// What the accelerometer should show at a sample: the drive as it is played, through the shaker's response.
// Real-time.
#include <array>
#include <complex>
#include <cstddef>
#include <optional>

#include "drivers/drive.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/time.hpp"

namespace shaker {

/// How the plant is known to behave, from the control thread for the one that reads the accelerometer.
struct Expectation {
    /// m/s^2 a volt at f, 2f, ... along `axis`, as the accelerometer shows them under the clock map below:
    /// its delay and low-pass are in the phases. Best the measured harmonics over those of the drive.
    std::array<std::complex<double>, max_harmonics> response{};
    double frequency = 20;         // Hz, that `response` is of
    std::array<double, 3> axis{};  // unit vector of the shaker in sensor axes; all 0: not known
    AccelTick at{};                // clock map: this sample was taken ...
    double dac_sample = 0;         // ... when this one of the DAC was heard, and
    double dac_per_tick = 12;      // so many of the DAC's pass in one of the accelerometer's
    double sigma = 0;              // noise of one accelerometer sample, m/s^2
    /// Largest residual, rms of a quarter period, as a share of the predicted rms. Infinite: none is judged.
    double tolerance = 0.3;
    double disturbance = 0.5;  // m/s^2 rms more that is no fault: the friction of a walker, a hand
    double settling_s = 0.05;  // time constant in which the base follows a change of the drive
};

class PredictedMotion {
public:
    /// rate_hz: of the accelerometer; frequency: of the synthesiser's silent start, dac_rate_hz: its rate.
    PredictedMotion(double rate_hz, double frequency, double dac_rate_hz) noexcept
        : rate_hz_{rate_hz},
          to_{.volts = {}, .frequency = frequency, .step = frequency / dac_rate_hz},
          frequency_{frequency} {}

    /// One of the frequency that is played corrects the prediction at once; one of another frequency waits
    /// for the change to it.
    void expect(const Expectation& expectation) noexcept;
    /// A change of the drive, told before it is heard, in order. Silence after lost time counts at once: the
    /// time before it was not as it had been told.
    void hear(const DriveChange& change) noexcept;

    struct Sample {
        double value = 0;  // m/s^2 along the axis
        double rms = 0;    // of a period at the amplitudes of this instant
        double slack = 0;  // rms that the base may be away because it still follows a change; far more
                           // than the motion while the frequency changes
    };
    /// Ticks do not fall. Empty while map or response are not known, and from a stop until the change after
    /// it.
    std::optional<Sample> at(AccelTick tick) noexcept;
    /// DAC sample at a tick, when the map is known.
    [[nodiscard]] std::optional<double> dac_sample(AccelTick tick) const noexcept;
    /// Frequency of the drive in force, Hz; of the newest change heard while there is no map.
    [[nodiscard]] double frequency() const noexcept { return frequency_; }
    /// The newest; only when at() has something to tell.
    [[nodiscard]] const Expectation& expectation() const noexcept { return *newest_; }

private:
    using Amplitudes = std::array<std::complex<double>, max_harmonics>;
    /// The drive at one end of a ramp and what it makes of the base.
    struct End {
        Harmonics<Voltage> volts;
        double frequency = 0;
        Amplitudes motion{};
        double step = 0;  // turns a DAC sample
        bool known = true;
    };
    static constexpr std::size_t most_waiting = 16;

    void begin(const DriveChange& change) noexcept;
    void predict(End& end) const noexcept;
    void weigh() noexcept;
    /// Of the newest change, x DAC samples after its first.
    [[nodiscard]] double slack_at(double x) const noexcept;

    double rate_hz_;
    std::optional<Expectation> newest_, before_;  // before_: of another frequency than the newest
    bool mapped_ = false, stopped_ = false, sweeps_ = false;
    std::array<DriveChange, most_waiting> waiting_{};
    std::size_t first_waiting_ = 0, waiting_count_ = 0;
    End from_, to_;
    double first_ = 0, ramp_ = 0;  // DAC samples
    double map_from_ = 0;          // DAC sample: maps of the clocks from before it no longer hold
    double phase_ = 0;             // turns at first_
    double change_rms_ = 0;        // of to_ minus from_
    double left_ = 0;              // slack at first_ of the changes before
    int order_ = 0;
    double frequency_;
};

}  // namespace shaker
