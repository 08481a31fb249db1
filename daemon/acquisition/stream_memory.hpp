#pragma once
// Memory that the streams of a measurement need.
#include "drivers/devices.hpp"

namespace shaker::acquisition {

/// Bytes that a measurement of this length (s) takes with its reduction, which copies the streams.
double memory_of(const Rig& rig, double measured_s);
/// InputError when a measurement of this length (s) does not fit into the available memory, with the longest
/// one that does. A system that does not report its memory allows all.
void require_memory(const Rig& rig, double measured_s);

}  // namespace shaker::acquisition
