#pragma once
// The bench that a rig file describes, opened.
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/settings_table.hpp"

namespace shaker {

struct HardwareRig {
    Rig rig;
    std::vector<std::string> granted;  // what the devices were asked for and gave, one sentence each
};

/// Opens the devices of a rig file: [dac] (alsa_settings.hpp), [accelerometer] (iio_settings.hpp) and each
/// [[camera]], which has geometry and targets (view_settings.hpp), a `driver`, "genicam" or "video", and that
/// driver's keys; further `trigger_delay_s`, from the pulse to the start of the exposure, and
/// `arrival_delay_s`, the least time from there until the host hears of the picture (of a camera that runs
/// free). All of the file is read before any device is opened; other tables than these must have been asked
/// for before. Throws InputError for the file, DeviceError for a device.
HardwareRig open_hardware_rig(SettingsTable& root);

}  // namespace shaker
