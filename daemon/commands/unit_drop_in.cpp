#include "daemon/commands/unit_drop_in.hpp"

#include <spdlog/fmt/fmt.h>

#include <set>

namespace shaker::commands {

namespace {

constexpr const char* head =
    "# Rights of shakerd.service for the devices of {0}, printed by \"shakerd devices --unit {0}\".\n"
    "# Put it into /etc/systemd/system/shakerd.service.d/bench.conf, then: systemctl daemon-reload; "
    "systemctl restart shakerd\n"
    "[Service]\n"
    "# No device of another kind:\n"
    "DeviceAllow=\n";

constexpr const char* clients =
    "# Clients on other computers (with `address` and `token_file` in the settings):\n"
    "#IPAddressAllow=<their network, for example 192.168.1.0/24>\n";

}  // namespace

std::string unit_drop_in(const std::filesystem::path& rig, const hardware::Kinds& kinds) {
    SettingsTable root = SettingsTable::from_file(rig);
    std::string text = fmt::format(head, rig.string());
    std::set<std::string> classes, addresses;
    for (const hardware::NamedAccess& device : hardware::access_of(root, kinds)) {
        std::string lines;
        for (const hardware::DeviceAccess& a : device.access) {
            if (!a.device_class.empty() && classes.insert(a.device_class).second)
                lines += "DeviceAllow=" + a.device_class + " rw\n";
            if (!a.address.empty() && addresses.insert(a.address).second)
                lines += "IPAddressAllow=" + a.address + "\n";
            if (!a.note.empty()) lines += "# " + a.note + "\n";
        }
        if (!lines.empty()) text += "# " + device.name + ":\n" + lines;
    }
    return text + clients;
}

}  // namespace shaker::commands
