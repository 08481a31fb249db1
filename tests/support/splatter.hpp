#pragma once
// How much a live change of the drive splashes into frequencies where the drive has nothing to say.
#include <span>
#include <vector>

#include "drivers/synthesiser.hpp"

namespace shaker::test {

/// Energy above `above_hz` relative to all energy, in dB, of a signal (any units) at `rate_hz` samples a
/// second. The signal is weighted with the eighth power of a sine, so its ends do not count and its middle
/// does most.
double splatter_db(std::span<const double> signal, double rate_hz, double above_hz);

/// Equal harmonics 1 and 2, as the paper's drive with rho = 1/2, gamma in volts.
DriveCommand biharmonic(double gamma, double phi, double frequency);

/// 1.4 s of signal at 48 kHz. In its middle one drive, at 20 Hz, gives way to another as the synthesiser does
/// it, over one period; or at once, at the start of a period, for comparison.
std::vector<double> around_ramp(const DriveCommand& from, const DriveCommand& to);
std::vector<double> around_jump(const DriveCommand& from, const DriveCommand& to);

}  // namespace shaker::test
