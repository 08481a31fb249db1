#include "daemon/remote/ctl/table.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "daemon/manual/help.hpp"
#include "daemon/orders/rows.hpp"
#include "daemon/remote/ctl/outcome.hpp"
#include "daemon/remote/ctl/state_text.hpp"

namespace shaker::ctl {

namespace {

using manual::Argument;
using manual::Command;
using manual::Kind;

template <void (*command)(const Values&)>
int done(const Values& values) {
    command(values);
    return exit_done;
}

void print_manual(const Values& /*values*/) { print(manual::manual_page(program())); }

constexpr Range waits{0, 30 * 86400.0};  // s

constexpr std::array<int, 5> asks{exit_refused, exit_not_reached};

constexpr std::array<std::string_view, 2> switch_words{"on", "off"};
constexpr std::array<std::string_view, 4> fetch_words{"state", "result", "points", "metrics"};

constexpr std::array common_arguments{Argument{.name = "--at",
                                               .value = "URL",
                                               .help = "Address of the daemon",
                                               .kind = Kind::text,
                                               .otherwise = "SHAKERD_URL, else http://127.0.0.1:8080"},
                                      Argument{.name = "--token-file",
                                               .value = "FILE",
                                               .help = "File of mode 600 with the daemon's token",
                                               .kind = Kind::file,
                                               .otherwise = "SHAKERD_TOKEN"},
                                      manual::help_option, manual::version_option};
static_assert(common_arguments[0].otherwise.ends_with(default_url));

constexpr std::array status_arguments{
    Argument{.name = "--json", .help = "Print the daemon's state as one line of JSON"}};

constexpr Argument argument_of(const orders::Field& field) {
    const Kind kind = field.kind == orders::Kind::quantity ? Kind::quantity
                      : field.kind == orders::Kind::whole  ? Kind::whole
                      : field.kind == orders::Kind::word   ? Kind::word
                      : field.kind == orders::Kind::flag   ? Kind::word
                                                           : Kind::text;
    return {.name = field.option,
            .value = field.value,
            .help = field.help,
            .kind = kind,
            .words = field.kind == orders::Kind::flag ? std::span<const std::string_view>{switch_words}
                                                      : field.words,
            .dimension = field.dimension,
            .allowed = field.allowed,
            .otherwise = field.otherwise};
}

constexpr std::size_t arguments_in(std::span<const orders::Field> fields) {
    return static_cast<std::size_t>(
        std::ranges::count_if(fields, [](const orders::Field& f) { return !f.option.empty(); }));
}

/// The arguments of an order, from its row; then `more`.
template <std::size_t place, std::size_t n = 0>
constexpr auto arguments_of(const std::array<Argument, n>& more = {}) {
    std::array<Argument, arguments_in(orders::table[place].fields) + n> all{};
    auto to = all.begin();
    for (const orders::Field& f : orders::table[place].fields)
        if (!f.option.empty()) *to++ = argument_of(f);
    std::ranges::copy(more, to);
    return all;
}

constexpr std::array wait_for_rest{Argument{.name = "--wait", .help = "Wait until the bench is idle"}};
constexpr std::array wait_for_result{
    Argument{.name = "--wait", .help = "Wait for the first result and print its v_D"}};
constexpr std::array wait_for_campaign{
    Argument{.name = "--wait", .help = "Wait until the campaign has ended; exit status 1 when it pauses"}};

template <std::size_t place>
constexpr auto plain_arguments = arguments_of<place>();
constexpr auto start_arguments = arguments_of<orders::place_of("start")>(wait_for_result);
constexpr auto scan_arguments = arguments_of<orders::place_of("campaign")>(wait_for_campaign);

/// A command from the row of an order. name: if it is not that of the order.
constexpr Command command_of(std::string_view order, std::span<const Argument> arguments,
                             int (*act)(const Values&), std::string_view name = {}) {
    const orders::Row& row = orders::table[orders::place_of(order)];
    return {.name = name.empty() ? row.name : name,
            .summary = row.summary,
            .details = row.details,
            .arguments = arguments,
            .example = row.example,
            .exit_statuses = asks,
            .act = act};
}

template <std::size_t place>
void give(const Values& values) {
    give_order(orders::table[place], values);
}
/// A command that only gives the order.
template <std::size_t place>
constexpr Command plain_command = command_of(orders::table[place].name, plain_arguments<place>,
                                             done<give<place>>);

constexpr std::array targets_arguments{Argument{.name = "--camera",
                                                .value = "NAME",
                                                .help = "Camera of the target to move",
                                                .kind = Kind::text,
                                                .otherwise = "print all regions"},
                                       Argument{.name = "--target",
                                                .value = "NAME",
                                                .help = "Target to move",
                                                .kind = Kind::text,
                                                .otherwise = "needed with --camera"},
                                       Argument{.name = "--region",
                                                .value = "X,Y,WIDTH,HEIGHT",
                                                .help = "Its new region in the picture, px",
                                                .kind = Kind::text,
                                                .otherwise = "needed with --camera"}};

constexpr std::array<std::string_view, 8> campaign_words{"plans",  "check", "start",  "pause",
                                                         "resume", "skip",  "repeat", "stop"};
constexpr std::array campaign_arguments{
    Argument{.name = "WHAT",
             .help =
                 "plans: list them; check: print how long a plan takes and which points do not fit; start; "
                 "pause; resume; skip the point in progress; repeat the last point; stop after the point "
                 "in progress",
             .kind = Kind::word,
             .words = campaign_words},
    Argument{.name = "--plan",
             .value = "NAME",
             .help = "Plan to check or start, one of \"campaign plans\"",
             .kind = Kind::text,
             .otherwise = "needed by check and start only"},
    wait_for_campaign[0]};

constexpr std::array watch_arguments{
    Argument{.name = "--json",
             .help = "Print each message of the daemon as one line of JSON, ten or more per second"},
    manual::quantity_option("--seconds", "S", Dimension::time, waits, "Exit after this time", {}, "never")};

constexpr std::array fetch_arguments{Argument{
    .name = "WHAT", .help = "state, result, points or metrics", .kind = Kind::word, .words = fetch_words}};

constexpr std::array wait_arguments{
    Argument{.name = "STATE", .help = "Name of a state", .kind = Kind::word, .words = state_words},
    manual::quantity_option("--timeout", "S", Dimension::time, waits, "Exit with status 75 after this time",
                            {}, "never")};

constexpr std::array<int, 5> waits_too{exit_refused, exit_not_reached, exit_timed_out};

constexpr std::array commands{
    Command{.name = "status",
            .summary = "Print the state of the bench",
            .arguments = status_arguments,
            .exit_statuses = asks,
            .act = done<status>},
    command_of("drive", plain_arguments<orders::place_of("drive")>, done<set_drive>, "set"),
    plain_command<orders::place_of("identify")>,
    command_of("start", start_arguments, done<start>),
    command_of("stop", wait_for_rest, done<stop>),
    command_of("middle", wait_for_rest, done<middle>),
    plain_command<orders::place_of("reset-walker")>,
    plain_command<orders::place_of("mu")>,
    Command{
        .name = "targets",
        .summary = "Print or move the regions in which the cameras' targets are searched",
        .details =
            "Without options: each target's region and the proposed one, which has moved with the target. "
            "A target is moved at rest only, and learned there; the region is in force until the daemon "
            "ends.",
        .arguments = targets_arguments,
        .example = "shakerctl targets --camera top --target walker --region 40,20,180,170",
        .exit_statuses = asks,
        .act = done<targets>},
    Command{.name = "campaign",
            .summary = "Measure the points of a plan without a person",
            .details = "The recordings and the table of points (campaign.nxs, for \"shakerd report\") are in "
                       "a folder of their own beside the daemon's recordings. A trip pauses the campaign: "
                       "clear it, then resume.",
            .arguments = campaign_arguments,
            .example = "shakerctl campaign start --plan fig3 --wait",
            .exit_statuses = asks,
            .act = done<campaign>},
    Command{.name = "abort",
            .summary = "Stop the drive at once, whoever holds control",
            .details =
                "The abort is latched: the drive can start again only after \"shakerctl clear\". It needs no "
                "token. If the output does not obey, a message and exit status 1 report it.",
            .exit_statuses = asks,
            .act = done<abort>},
    command_of("clear", {}, done<clear>),
    plain_command<orders::place_of("record")>,
    plain_command<orders::place_of("remark")>,
    plain_command<orders::place_of("loop")>,
    plain_command<orders::place_of("limit")>,
    [] {
        Command scanned = command_of("campaign", scan_arguments, done<scan>, "scan");
        scanned.summary = "Measure v_D at values of one parameter, one after the other";
        return scanned;
    }(),
    Command{
        .name = "watch",
        .summary = "Print state and v_D once a second, and every event",
        .details =
            "The first lines are the newest past events. The command exits on Ctrl-C, or when its output is "
            "closed. With --json, the first state and the state after each measurement contain all measured "
            "points.",
        .arguments = watch_arguments,
        .exit_statuses = asks,
        .act = done<watch>},
    Command{
        .name = "fetch",
        .summary = "Print data of the daemon as JSON in SI units, or its metrics as text",
        .details = "The result is the newest measurement with its cycle. Points are all stored measurements.",
        .arguments = fetch_arguments,
        .exit_statuses = asks,
        .act = done<fetch>},
    Command{.name = "wait",
            .summary = "Wait until the bench is in a state",
            .details = "A trip or an abort ends the wait with exit status 1. A daemon that is starting has 5 "
                       "s to accept "
                       "a connection.",
            .arguments = wait_arguments,
            .example = "shakerctl wait idle --timeout 60s",
            .exit_statuses = waits_too,
            .act = done<wait_for>},
    Command{.name = "manual", .summary = "Print the manual page, for man -l", .act = done<print_manual>},
};

// Sections of the manual page that no table describes.
using Item = std::array<std::string_view, 2>;  // a term and its meaning

constexpr std::array environment_items{
    Item{"SHAKERD_URL", "Address of the daemon, used without --at."},
    Item{"SHAKERD_TOKEN", "Token of the daemon, used without --token-file."}};

constexpr std::array manual_sections{
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

constexpr manual::Program shakerctl{
    .name = "shakerctl",
    .manual_part = 1,
    .title = "commands to a shaker bench on call",
    .synopsis = "[--at URL] [--token-file FILE] COMMAND [ARGUMENTS]",
    .about = "shakerctl queries the daemon \"shakerd serve\" and sends it orders, for shells and scripts.",
    .notation =
        "Quantities carry units: 1.5g, 14.7m/s^2, 35deg, 0.61rad, 20Hz, 500ms. A bare number is in SI units. "
        "g is 9.8 m/s^2.",
    .commands = commands,
    .common = common_arguments,
    .exit_statuses = exit_statuses,
    .sections = manual_sections};

}  // namespace

const manual::Program& program() { return shakerctl; }

Link link_of(const Values& values) {
    const auto environment = [](const char* name) {
        const char* value = std::getenv(name);
        return std::string{value == nullptr ? "" : value};
    };
    Link link{.at = {}, .token = {}, .client = client_name()};
    const std::string url = environment("SHAKERD_URL");
    if (values.has("--at"))
        link.at = address_of("--at", values.text("--at"));
    else
        link.at =
            url.empty() ? address_of("the built-in address", default_url) : address_of("SHAKERD_URL", url);
    link.token = values.has("--token-file") ? token_of_file(values.text("--token-file"))
                                            : checked_token("SHAKERD_TOKEN", environment("SHAKERD_TOKEN"));
    return link;
}

}  // namespace shaker::ctl
