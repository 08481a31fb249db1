#pragma once
// The row of this folder in a table of kinds, and the devices that are connected.
#include <array>
#include <vector>

#include "drivers/hardware/kind/device_kind.hpp"

namespace shaker::iio {

hardware::OpenAccelerometer read_kind(SettingsTable& table);
/// Searches this computer, USB, and the given addresses ("ip:host:port"). Devices that cannot stream are left
/// out; a context that could not be opened is listed with the reason.
std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search);

inline constexpr std::array search_options{
    hardware::SearchOption{.name = "--iio",
                           .value = "URI",
                           .help = "Also search for accelerometers at this address, e.g. ip:192.168.1.7",
                           .many = true}};

inline constexpr hardware::AccelerometerKind iio_kind{
    .name = "iio",
    .heading = "[accelerometer]",
    .key = "accelerometers",
    .read = read_kind,
    .list = list_kind,
    .search = search_options,
    .advice = {.silent = "is its trigger running, and its buffer enabled?",
               .rate_off = "is its sampling_frequency the one in the rig file?"}};

}  // namespace shaker::iio
