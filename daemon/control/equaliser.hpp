#pragma once
// Closes the drive loop once a period: measured harmonics in, the next harmonics of voltage out.
#include <array>
#include <complex>

#include "daemon/control/harmonic_estimator.hpp"
#include "drivers/drive.hpp"

namespace shaker {

struct EqualiserSettings {
    /// Nominal response of shaker and amplifier at q f, m/s^2 per V, without the pure delay; non-zero up to
    /// order.
    std::array<std::complex<double>, max_harmonics> response{};
    int order = 8;          // harmonics that are corrected; those above are never driven
    int delay_periods = 2;  // from a drive being told to the first period measured under it alone
    double mu = 0.15;       // gain of the integral control, at most largest_gain(delay_periods)
    double limit_V = 1.0;   // no planned waveform peaks higher
    double step = 0.2;  // largest change a period, relative to the drive (to the planned drive at the start)
    double start_level =
        0.3;  // part of the planned drive to begin with, as the response may be larger than thought
};

/// Integral control of every harmonic, U_q += mu (R_q - Y_q e^{i q delta}) / H_q, where delta turns the
/// measured harmonic 1 (2, when the target has no first) onto the target's phase: the time between drive and
/// sensor is not controlled, and a constant lag changes nothing. Stable while psi_q - q psi_1 stays well
/// inside 90 degrees, psi the phase error of the response; a harmonic whose residual grows all the same is
/// put back to its best and held. Invalid or implausible measurements hold the drive; they never raise it.
/// Nothing allocates. One thread.
class Equaliser {
public:
    struct Report {
        std::array<double, max_harmonics>
            residual_db{};                       // |R_q - Y_q| against gamma, mean of about 10 periods
        std::array<bool, max_harmonics> held{};  // no longer corrected: its residual grew
        double gamma = 0;  // of the target in force, m/s^2: less than asked when the voltage limit is reached
        double scale = 1;  // that over the asked one
        double lag_turns = 0;  // delta: drive to sensor, in periods, -0.5..0.5
        double peak_V = 0;     // of the planned waveform
        bool locked = false;   // every residual below -60 dB
        bool implausible =
            false;        // last measurement was invalid, or below a tenth of what the drive should do
        int ignored = 0;  // measurements in a row that were not used
    };

    /// Throws InputError naming the setting, its value and what is allowed.
    explicit Equaliser(const EqualiserSettings& settings);
    /// A new target; the drive follows at once as far as the response is known. Harmonics above order are
    /// ignored.
    void set_target(const Harmonics<Acceleration>& target);
    /// What the last period showed; returns the drive from now on.
    const Harmonics<Voltage>& update(const HarmonicEstimate& measured) noexcept;
    [[nodiscard]] const Harmonics<Voltage>& drive() const noexcept { return drive_; }
    [[nodiscard]] const Report& report() const noexcept { return report_; }
    /// A third of the gain at which the loop with this delay turns unstable: (2/3) sin(pi / (2 (2 delay +
    /// 1))).
    static double largest_gain(int delay_periods) noexcept;

private:
    using Complex = std::complex<double>;
    struct Best {
        double error = 0;
        Complex drive = 0;
        int grown = 0;
    };
    [[nodiscard]] bool plausible(const HarmonicEstimate& measured) const noexcept;
    [[nodiscard]] double lag(const Harmonics<Acceleration>& measured) const noexcept;
    Complex correction(int q, Complex error, double sd) noexcept;
    void apply(const Harmonics<Voltage>& change, double room) noexcept;
    void limit_peak() noexcept;
    void judge() noexcept;

    EqualiserSettings settings_;
    Harmonics<Acceleration> asked_;
    Harmonics<Voltage> drive_;
    std::array<Complex, max_harmonics> mean_error_{};
    std::array<Best, max_harmonics> best_{};
    Report report_;
    bool started_ = false;
    bool near_ = false;  // amplitudes are within a tenth of the target's
    int measured_ = 0;   // used since the target changed
};

}  // namespace shaker
