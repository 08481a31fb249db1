#pragma once
// Response of an accelerometer over frequency: lower corner and low-pass. Both turn the first harmonic and
// the second by different times, which no delay does.
#include <complex>
#include <numbers>
#include <string>

namespace shaker {

/// A high-pass of one pole, or of two: 1 / (1 - i x) or 1 / (1 - 2i damping x - x^2) with x = hz / f.
/// Default: coupled down to DC.
struct LowerCorner {
    double hz = 0;                                // of each pole
    double error_hz = 0;                          // its standard error; infinite: not known
    int poles = 1;                                // 0: one or two
    double damping = 1;                           // of two poles: 1: equal ones, 0.71: Butterworth
    static constexpr double of_data_sheet = 0.1;  // usual relative error
    /// Nothing is to be corrected.
    [[nodiscard]] bool none() const noexcept { return hz == 0 && error_hz == 0; }
    /// Output over input at a frequency, Hz.
    [[nodiscard]] std::complex<double> at(double frequency_hz) const;
    /// Derivative of the logarithm of at() by hz.
    [[nodiscard]] std::complex<double> log_rate(double frequency_hz) const;
    bool operator==(const LowerCorner&) const = default;
};

/// A low-pass of one pole, or of two: 1 / (1 + i x) or 1 / (1 + 2i damping x - x^2) with x = f / hz. Its
/// delay at low frequencies is left out: it belongs to the lag of the sensor's clock, which the cameras show.
struct LowPass {
    double hz = 0;  // of each pole; 0: none is known
    double error_hz = 0;
    int poles = 2;
    double damping = 1 / std::numbers::sqrt2;
    double above_hz =
        0;  // without hz: one of two poles is above this with a probability of 95 %; 0: not known
    [[nodiscard]] bool none() const noexcept { return hz == 0; }
    [[nodiscard]] std::complex<double> at(double frequency_hz) const;
    [[nodiscard]] std::complex<double> log_rate(double frequency_hz) const;
    /// Standard error of phi of a drive of frequency f, rad; NaN: nothing is known.
    [[nodiscard]] double phi_error(double f) const;
    bool operator==(const LowPass&) const = default;
};

struct SensorResponse {
    LowerCorner lower{};
    LowPass upper{};
    std::string file{};  // content of the file that told them; empty: the settings
    [[nodiscard]] bool none() const noexcept { return lower.none() && upper.none(); }
    [[nodiscard]] std::complex<double> at(double frequency_hz) const {
        return lower.at(frequency_hz) * upper.at(frequency_hz);
    }
    bool operator==(const SensorResponse&) const = default;
};

/// How a response turns phi = alpha2 - 2 alpha1 of a drive of frequency f, and the derivative of that.
template <class Part>
double phi_turned(const Part& part, double f) {
    return std::arg(part.at(2 * f)) - 2 * std::arg(part.at(f));
}
template <class Part>
double phi_turned_by_hz(const Part& part, double f) {
    return part.log_rate(2 * f).imag() - 2 * part.log_rate(f).imag();
}

}  // namespace shaker
