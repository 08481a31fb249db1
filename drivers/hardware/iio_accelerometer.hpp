#pragma once
// An accelerometer behind libiio: on this machine, over a network or over USB.
#include <memory>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/hardware/iio_settings.hpp"

namespace shaker {

/// Connects, sets the device up, and makes sure that its buffer can be had. Throws DeviceError naming the
/// device, what was asked and libiio's words. `notes`, where given, gets what could not be had (stamps, the
/// monotonic clock, buffers of the size asked for) and is no reason not to go on.
///
/// The first read() starts a thread that alone waits for libiio; it takes over the priority of the caller.
/// Blocks hold the device's counts as they are. Ticks count missing samples too: found by gaps in the stamps
/// (see SampleGrid: stamps may be late by many steps, only what stays counts), or, without stamps, by the
/// time for which the connection was broken. After a loss of samples the block is Quality::gap; samples at
/// the ends of the counts or beyond range_mps2 make it Quality::clipped.
///
/// Whatever libiio reports, context and buffer are built anew, at once and then every 20 to 500 ms;
/// counts().incidents and .reopened tell how often, and a clock of the device that was set is an incident
/// too. A device that comes back with another scale or rate does not count as back. read() throws DeviceError
/// once nothing has come for give_up_s. stop() ends a wait in libiio within 0.1 s, except for one in
/// connecting: the destructor may then wait for libiio's own 5 s.
std::unique_ptr<Accelerometer> open_iio_accelerometer(const IioSettings& settings,
                                                      std::vector<std::string>* notes = nullptr);

}  // namespace shaker
