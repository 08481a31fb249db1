#pragma once
// What libiio finds: for `shakerd devices`.
#include <string>
#include <vector>

namespace shaker {

/// A device that can stream samples, as it tells of itself.
struct IioDeviceSeen {
    std::string uri;  // to be given as IioSettings::uri
    std::string id{}, name{}, label{}, serial{};
    std::vector<std::string> channels{};  // that can be buffered, with their format: "accel_x be:s20/32>>12"
    std::string rate_hz{};                // as it is, as text; empty: not told
    std::string rates_hz{};               // to choose among, likewise
    std::string trigger{};                // that it has now
    bool has_stamps = false;
};

/// One place where devices may be.
struct IioContextSeen {
    std::string uri;
    std::string description{};
    std::vector<IioDeviceSeen> devices{};
    std::vector<std::string> triggers{};  // all there are, by name
    std::string trouble{};                // libiio's words where it could not be opened
};

/// Looks on this machine, on USB, and at the addresses given ("ip:host:port"). Devices that cannot stream are
/// left out; places without devices are in the list with what was the matter. Does not throw for a device.
std::vector<IioContextSeen> list_iio_devices(const std::vector<std::string>& uris);

}  // namespace shaker
