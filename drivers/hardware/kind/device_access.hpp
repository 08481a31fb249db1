#pragma once
// Access rights that the service unit must give for a device.
#include <string>

namespace shaker::hardware {

struct DeviceAccess {
    std::string device_class{};  // of its device node: "char-alsa"; empty: it has none
    std::string address{};       // IP address with which packets are exchanged; empty: none
    std::string note{};          // what the operator must add; empty: nothing
};

}  // namespace shaker::hardware
