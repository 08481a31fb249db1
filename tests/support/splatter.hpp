#pragma once
// How much a live change of the drive splashes into frequencies where the drive has nothing to say.
#include <span>

namespace shaker::test {

/// Energy above `above_hz` relative to all energy, in dB, of a signal (any units) at `rate_hz` samples a
/// second. The signal is weighted with the fourth power of a Hann window, so its ends do not count and its
/// middle does most.
double splatter_dB(std::span<const double> signal, double rate_hz, double above_hz);

}  // namespace shaker::test
