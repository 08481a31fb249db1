#pragma once
// An accelerometer behind libiio: on this machine, over a network or over USB.
#include <memory>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/hardware/iio/settings.hpp"

namespace shaker::iio {

/// Connects, sets up the device and checks that its buffer can be created. Throws DeviceError that names the
/// device, the request and libiio's text. `notes`, if given, receives settings that were not available but
/// are not required (stamps, the monotonic clock, the requested buffer size).
///
/// The first read() starts a thread that alone waits for libiio; it inherits the caller's priority. Blocks
/// hold the device's counts unchanged. Ticks include missing samples, which are found by gaps in the stamps
/// (SampleGrid: stamps may be late by many steps; only a lasting delay counts) or, without stamps, by the
/// duration of a broken connection. A block after a loss has Quality::gap; samples at the ends of the counts
/// or beyond range_mps2 make it Quality::clipped.
///
/// After any error of libiio, context and buffer are created again, at once and then every 20 to 500 ms.
/// counts().incidents and .reopened count this; a device clock that was set is an incident too. A device that
/// returns with another scale or rate is not accepted. read() throws DeviceError after give_up_s without
/// samples. stop() ends a wait in libiio within 0.1 s, except while connecting: the destructor may then wait
/// for libiio's own 5 s.
std::unique_ptr<Accelerometer> open_iio_accelerometer(const IioSettings& settings,
                                                      std::vector<std::string>* notes = nullptr);

}  // namespace shaker::iio
