#pragma once
// The row of this folder in a table of kinds, and the devices that are connected.
#include <array>
#include <string>
#include <vector>

#include "drivers/hardware/kind/device_kind.hpp"

namespace shaker::iio {

/// A device that can stream samples, with its own description.
struct IioDeviceSeen {
    std::string uri;  // value for IioSettings::uri
    std::string id{}, name{}, label{}, serial{};
    std::vector<std::string> channels{};  // scan elements with their format: "accel_x be:s20/32>>12"
    std::string rate_hz{};                // present rate, as text; empty: unknown
    std::string rates_hz{};               // available rates, as text; empty: unknown
    std::string trigger{};                // present trigger
    bool has_stamps = false;
};

/// A context: this machine, a USB device or a network address.
struct IioContextSeen {
    std::string uri;
    std::string description{};
    std::vector<IioDeviceSeen> devices{};
    std::vector<std::string> triggers{};  // names of all triggers
    std::string trouble{};                // libiio's text when it could not be opened
};

/// Searches this machine, USB, and the given addresses ("ip:host:port"). Devices that cannot stream are left
/// out; contexts without devices are listed with the reason. Does not throw for a device.
std::vector<IioContextSeen> list_iio_devices(const std::vector<std::string>& uris);

hardware::OpenAccelerometer read_kind(SettingsTable& table);
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
