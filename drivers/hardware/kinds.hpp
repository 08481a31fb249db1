#pragma once
// The tables of device kinds. To add a kind: write its folder with a row (kind.hpp), name the row here.
#include <array>

#include "drivers/hardware/alsa/kind.hpp"
#include "drivers/hardware/genicam/kind.hpp"
#include "drivers/hardware/gpio/lines.hpp"
#include "drivers/hardware/iio/kind.hpp"
#include "drivers/hardware/kind/device_kind.hpp"
#include "drivers/hardware/video/kind.hpp"

namespace shaker::hardware {

inline constexpr std::array dac_kinds{alsa::alsa_kind};
inline constexpr std::array accelerometer_kinds{iio::iio_kind};
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

}  // namespace shaker::hardware
