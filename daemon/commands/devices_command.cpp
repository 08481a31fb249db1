#include "daemon/commands/devices_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <nlohmann/json.hpp>

#include "daemon/report/printing.hpp"

namespace shaker::commands {

void list_devices(const DevicesOptions& options) {
    const std::vector<hardware::ListedKind> kinds = hardware::list_devices(options.search);
    nlohmann::ordered_json json;
    for (const hardware::ListedKind& kind : kinds) {
        nlohmann::ordered_json& list = json[std::string{kind.key}] = nlohmann::ordered_json::array();
        std::string text;
        for (const hardware::ListedDevice& device : kind.devices) {
            list.push_back(nlohmann::ordered_json::parse(device.json));
            text += device.text;
        }
        if (!options.json) report::say(fmt::format("{}\n{}", kind.heading, text.empty() ? "  none\n" : text));
    }
    if (options.json) report::say(json.dump(2) + "\n");
}

}  // namespace shaker::commands
