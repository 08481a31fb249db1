#pragma once
// Lists the devices found by libiio, for `shakerd devices`.
#include <string>
#include <vector>

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

}  // namespace shaker::iio
