#pragma once
// Closes the drive loop: measured harmonics of the base correct the harmonics of the voltage. First version:
// integral action per harmonic with the shaker's nominal response.
#include <array>
#include <complex>
#include <optional>

#include "drivers/drive.hpp"

namespace shaker {

struct EqualiserSettings {
    int harmonics = 8;  // 1..16 are corrected, those that the target does not have towards zero
    /// Share of the error taken away at a step. Stable while |1 - gain H/H_nominal| < 1, that is for
    /// gain < 2 cos(psi)/r when the true response is r e^{i psi} times the nominal one.
    double gain = 0.5;
    double volts_limit = 1;        // peak of the planned waveform
    double lock_amplitude = 5e-4;  // locked: every harmonic within this share of gamma, or within three sd
};

/// Works on settled periods: give it an estimate of a period that lay wholly behind the last change of the
/// drive. A constant delay between drive and sensor does not matter: it turns harmonic q by q times a phase,
/// and phases are compared after the turn that brings harmonic 1 onto its target. An error psi_1 of the
/// nominal response's phase at harmonic 1 therefore counts q times at harmonic q: psi = psi_q - q psi_1.
class Equaliser {
public:
    struct Report {
        std::array<double, max_harmonics> residual{};  // |measured - target| / gamma, a harmonic
        bool locked = false;  // every corrected harmonic is near enough to its target
        double reached = 1;   // share of the asked gamma that the volts_limit lets through
        double noise = 0;     // sd / gamma of the estimate
    };

    /// response: m/s^2 a volt at f, 2f, ...; finite and not zero.
    Equaliser(const Harmonics<Acceleration>& target,
              const std::array<std::complex<double>, max_harmonics>& response,
              const EqualiserSettings& settings = {});

    /// The drive to begin with: target / response, within the limit.
    [[nodiscard]] const Harmonics<Voltage>& volts() const noexcept { return volts_; }
    /// Takes one settled period (its harmonics and their standard deviation) and steps. An estimate that is
    /// not finite, or that shows no motion, changes nothing: the drive is never raised on missing data.
    Report update(const Harmonics<Acceleration>& measured, double sd);

private:
    void keep_within_limit();

    Harmonics<Acceleration> target_;
    std::array<std::complex<double>, max_harmonics> response_;
    EqualiserSettings settings_;
    Harmonics<Voltage> volts_;
    double reached_ = 1;
};

/// Largest |value| of a period, evaluated at 512 points and refined by a parabola.
double peak(const Harmonics<Voltage>& volts);

}  // namespace shaker
