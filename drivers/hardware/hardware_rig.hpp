#pragma once
// Opens the devices of a rig file.
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/hardware/kinds.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::hardware {

struct HardwareRig {
    Rig rig;
    std::vector<std::string> granted;  // requested and granted settings of the devices, one sentence each
};

/// Opens the devices of a rig file: [dac], [accelerometer] and each [[camera]]. The key `driver` names the
/// kind; a [dac] or an [accelerometer] without it is of the first kind of its table. Each table has the keys
/// of its kind (settings.hpp in the folder of the kind). A camera also has geometry and targets
/// (view_settings.hpp), `trigger_delay_s`, from the pulse to the start of the exposure, and
/// `arrival_delay_s`, the shortest time from there to the arrival of the picture at the host (of a
/// free-running camera). The caller reads the key `calibration` of [accelerometer].
/// [abort] is an optional line of a GPIO chip (gpio/settings.hpp). The
/// whole file is read before any device is opened; the caller reads other tables before. Throws InputError
/// for the file, DeviceError for a device.
HardwareRig open_hardware_rig(SettingsTable& root, const Kinds& kinds = {});

}  // namespace shaker::hardware
