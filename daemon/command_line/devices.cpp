#include "daemon/command_line/rows.hpp"
#include "daemon/commands/devices_command.hpp"

namespace shaker::command_line {

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
    all.push_back(json_argument);
    return all;
}

const std::vector<Argument>& arguments() {
    static const std::vector<Argument> all = all_arguments();
    return all;
}

int act(const manual::Values& values) {
    commands::DevicesOptions options{.json = values.has("--json")};
    for (const Argument& a : arguments())
        if (a.kind != Kind::flag && values.has(a.name))
            options.search[std::string{a.name}] = values.texts(a.name);
    commands::list_devices(options);
    return manual::exit_ok;
}

}  // namespace

manual::Command devices_row() {
    return {.name = "devices",
            .summary = "List the connected devices and their capabilities",
            .details = "The output has the keys of a rig file.",
            .arguments = arguments(),
            .example = "shakerd devices --iio ip:192.168.1.7",
            .act = act};
}

}  // namespace shaker::command_line
