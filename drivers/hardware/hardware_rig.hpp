#pragma once
// Opens the devices of a rig file, by the tables of device kinds. To add a kind: write its folder with a row
// (kind.hpp), name the row here.
#include <array>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/hardware/alsa/kind.hpp"
#include "drivers/hardware/alsa_input/kind.hpp"
#include "drivers/hardware/genicam/kind.hpp"
#include "drivers/hardware/gpio/contact_input.hpp"
#include "drivers/hardware/iio/kind.hpp"
#include "drivers/hardware/kind/device_kind.hpp"
#include "drivers/hardware/video/kind.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::hardware {

inline constexpr std::array dac_kinds{alsa::alsa_kind};
inline constexpr std::array accelerometer_kinds{iio::iio_kind, alsa_input::alsa_input_kind};
inline constexpr std::array camera_kinds{genicam::genicam_kind, video::video_kind};

/// The tables by which a rig file is read and devices are listed.
struct Kinds {
    std::span<const DacKind> dacs = dac_kinds;
    std::span<const AccelerometerKind> accelerometers = accelerometer_kinds;
    std::span<const CameraKind> cameras = camera_kinds;
    gpio::OpenInput open_line = gpio::open_input;  // of [abort]
};

/// The devices of one kind that are connected.
struct ListedKind {
    std::string_view heading, key;  // as DeviceKind has them
    std::vector<ListedDevice> devices;
};

/// Every kind, in the order of the tables: DACs, accelerometers, cameras.
std::vector<ListedKind> list_devices(const Search& search, const Kinds& kinds = {});

struct HardwareRig {
    Rig rig;
    std::vector<std::string> granted;  // requested and granted settings of the devices, one sentence each
};

/// Opens the devices of a rig file: [dac], [accelerometer] and each [[camera]]. The key `driver` names the
/// kind; a [dac] or an [accelerometer] without it is of the first kind of its table. Each table has the keys
/// of its kind (settings.hpp or video_camera.hpp in the folder of the kind). A camera also has geometry and
/// targets (view_settings.hpp), `trigger_delay_s`, from the pulse to the start of the exposure, and
/// `arrival_delay_s`, the shortest time from there to the arrival of the picture at the host (of a
/// free-running camera). The caller reads the key `calibration` of [accelerometer].
/// [abort] is an optional line of a GPIO chip (gpio/contact_input.hpp). The
/// whole file is read before any device is opened; the caller reads other tables before. Throws InputError
/// for the file, DeviceError for a device.
HardwareRig open_hardware_rig(SettingsTable& root, const Kinds& kinds = {});

}  // namespace shaker::hardware
