#include <spdlog/fmt/fmt.h>

#include <nlohmann/json.hpp>

#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/hardware/hardware_rig.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr Argument argument_of(const hardware::SearchOption& option) {
    return {.name = option.name,
            .value = option.value,
            .help = option.help,
            .kind = option.file ? Kind::file : Kind::text,
            .many = option.many,
            .must_exist = option.file};
}

// The search options of every kind, then --json.
std::vector<Argument> all_arguments() {
    std::vector<Argument> all;
    const auto add = [&](const auto& kinds) {
        for (const auto& kind : kinds)
            for (const hardware::SearchOption& option : kind.search) all.push_back(argument_of(option));
    };
    add(hardware::dac_kinds);
    add(hardware::accelerometer_kinds);
    add(hardware::camera_kinds);
    all.push_back(manual::json_argument);
    return all;
}

const std::vector<Argument>& devices_arguments() {
    static const std::vector<Argument> all = all_arguments();
    return all;
}

// Prints the connected devices and their capabilities with the keys of a rig file.
void list_devices(const hardware::Search& search, bool as_json) {
    const std::vector<hardware::ListedKind> kinds = hardware::list_devices(search);
    nlohmann::ordered_json json;
    for (const hardware::ListedKind& kind : kinds) {
        nlohmann::ordered_json& list = json[std::string{kind.key}] = nlohmann::ordered_json::array();
        std::string text;
        for (const hardware::ListedDevice& device : kind.devices) {
            list.push_back(nlohmann::ordered_json::parse(device.json));
            text += device.text;
        }
        if (!as_json) report::say(fmt::format("{}\n{}", kind.heading, text.empty() ? "  none\n" : text));
    }
    if (as_json) report::say(json.dump(2) + "\n");
}

int act_on_devices(const manual::Values& values) {
    hardware::Search search;
    for (const Argument& a : devices_arguments())
        if (a.kind != Kind::flag && values.has(a.name)) search[std::string{a.name}] = values.texts(a.name);
    list_devices(search, values.has("--json"));
    return manual::exit_ok;
}

}  // namespace

manual::Command devices_row() {
    return {.name = "devices",
            .summary = "List the connected devices and their capabilities",
            .details = "The output has the keys of a rig file.",
            .arguments = devices_arguments(),
            .example = "shakerd devices --iio ip:192.168.1.7",
            .act = act_on_devices};
}

}  // namespace shaker::commands
