#pragma once
// Lower corner of a sensor whose output has no constant part. It turns the first harmonic more than the
// second, which no delay does.
#include <complex>

namespace shaker {

/// A high-pass of equal poles. Default: coupled down to DC.
struct LowerCorner {
    double hz = 0;                                // of each pole
    double error_hz = 0;                          // its standard error; infinite: not known
    int poles = 1;                                // 0: one or two
    static constexpr double of_data_sheet = 0.1;  // usual relative error
    /// Nothing is to be corrected.
    [[nodiscard]] bool none() const noexcept { return hz == 0 && error_hz == 0; }
    /// Output over input at a frequency, Hz.
    [[nodiscard]] std::complex<double> at(double frequency_hz) const;
    bool operator==(const LowerCorner&) const = default;
};

}  // namespace shaker
