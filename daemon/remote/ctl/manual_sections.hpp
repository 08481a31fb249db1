#pragma once
// Sections of the manual page of shakerctl that no table describes.
#include <array>

#include "daemon/manual/command.hpp"

namespace shaker::ctl {

using Item = std::array<std::string_view, 2>;  // a term and its meaning

inline constexpr std::array environment_items{
    Item{"SHAKERD_URL", "Address of the daemon, used without --at."},
    Item{"SHAKERD_TOKEN", "Token of the daemon, used without --token-file."}};

inline constexpr std::array manual_sections{
    manual::Section{
        .title = "CONTROL",
        .paragraph =
            "Each call of shakerctl is a separate client that holds control only during its order. While a "
            "page or another client holds control, the daemon refuses orders, and its answer names the "
            "holder. The daemon obeys an abort whoever holds control."},
    manual::Section{.title = "ENVIRONMENT", .items = environment_items},
    manual::Section{
        .title = "NOTES",
        .paragraph =
            "The daemon has 5 s to answer, and 2 s to answer an abort. An order without an answer may have "
            "been executed: \"shakerctl status\" shows it. The system looks up the name of a machine, which "
            "may take longer: give a numeric address where an abort must not wait. Control characters in "
            "answers of the daemon are printed as \\x1b. Software is not the emergency stop."},
    manual::Section{.title = "EXAMPLES",
                    .example = "shakerctl set --gamma 1.5g --phi 35deg\n"
                               "shakerctl record on --name series-1\n"
                               "shakerctl start --periods 40 --wait && shakerctl fetch result >result.json\n"
                               "shakerctl stop --wait\n"
                               "shakerctl watch --json | jq -r 'select(.type == \"event\").text'\n"},
    manual::Section{.title = "SEE ALSO", .paragraph = "shakerd(8)"},
};

}  // namespace shaker::ctl
