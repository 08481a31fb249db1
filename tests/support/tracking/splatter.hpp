#pragma once
// Energy that a change of the drive puts at frequencies outside the drive.
#include <span>
#include <vector>

#include "drivers/synthesiser.hpp"

namespace shaker::test {

/// Energy above `above_hz` relative to all energy, in dB, of a signal (any units) at `rate_hz` samples per
/// second. The signal is weighted with the eighth power of a sine: its middle has the largest weight, its
/// ends have none.
double splatter_db(std::span<const double> signal, double rate_hz, double above_hz);

/// Equal harmonics 1 and 2: the drive of the paper with rho = 1/2, gamma in volts.
DriveCommand biharmonic(double gamma, double phi, double frequency);

/// 1.4 s of signal at 48 kHz. In its middle the synthesiser changes from one drive at 20 Hz to another, over
/// one period; or, for comparison, at once at the start of a period.
std::vector<double> around_ramp(const DriveCommand& from, const DriveCommand& to);
std::vector<double> around_jump(const DriveCommand& from, const DriveCommand& to);

}  // namespace shaker::test
