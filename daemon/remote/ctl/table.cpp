#include "daemon/remote/ctl/table.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "daemon/manual/help.hpp"
#include "daemon/manual/values.hpp"
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

constexpr std::array<std::string_view, 2> switch_words{"on", "off"};
constexpr std::array<std::string_view, 4> frames_words{"off", "first-second", "region", "full"};
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

constexpr auto set_arguments = manual::drive_arguments(false);

constexpr Argument argument_of(const MeasurementField& field) {
    return {.name = field.option,
            .value = "N",
            .help = field.help,
            .kind = Kind::whole,
            .allowed = field.allowed,
            .otherwise = field.otherwise};
}

constexpr auto start_arguments = [] {
    std::array<Argument, measurement_fields.size() + 1> rows{};
    std::ranges::transform(measurement_fields, rows.begin(), argument_of);
    rows.back() = {.name = "--wait", .help = "Wait for the first result and print its v_D"};
    return rows;
}();

constexpr std::array stop_arguments{Argument{.name = "--wait", .help = "Wait until the bench is idle"}};

constexpr std::array middle_arguments{Argument{.name = "--wait", .help = "Wait until the bench is idle"}};

constexpr std::array mu_arguments{Argument{.name = "MU",
                                           .help = "Coefficient of Coulomb friction",
                                           .kind = Kind::quantity,
                                           .dimension = Dimension::ratio,
                                           .allowed = allowed_friction},
                                  Argument{.name = "--error",
                                           .value = "ERROR",
                                           .help = "Standard error of MU",
                                           .kind = Kind::quantity,
                                           .dimension = Dimension::ratio,
                                           .allowed = {0, 3},
                                           .otherwise = "0"}};

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
    Argument{.name = "--wait", .help = "Wait until the campaign has ended; exit status 1 when it pauses"}};

constexpr std::array record_arguments{
    Argument{.name = "SWITCH", .help = "on or off", .kind = Kind::word, .words = switch_words},
    Argument{.name = "--name",
             .value = "NAME",
             .help = "Name of the next recording, without folder or ending",
             .kind = Kind::text,
             .otherwise = "the time"},
    Argument{.name = "--frames",
             .value = "WHICH",
             .help = "Pictures to record: off, first-second (those of the first second; then positions "
                     "only), region (all, "
                     "of the part that can contain targets) or full",
             .kind = Kind::word,
             .words = frames_words,
             .otherwise = "as last"}};

constexpr std::array remark_arguments{Argument{
    .name = "TEXT", .help = "1 to 400 bytes in quotes: \"new paper under the walker\"", .kind = Kind::text}};

constexpr std::array watch_arguments{
    Argument{.name = "--json",
             .help = "Print each message of the daemon as one line of JSON, ten or more per second"},
    Argument{.name = "--seconds",
             .value = "S",
             .help = "Exit after this time",
             .kind = Kind::quantity,
             .dimension = Dimension::time,
             .allowed = waits,
             .otherwise = "never"}};

constexpr std::array fetch_arguments{Argument{
    .name = "WHAT", .help = "state, result, points or metrics", .kind = Kind::word, .words = fetch_words}};

constexpr std::array wait_arguments{
    Argument{.name = "STATE", .help = "Name of a state", .kind = Kind::word, .words = state_words},
    Argument{.name = "--timeout",
             .value = "S",
             .help = "Exit with status 75 after this time",
             .kind = Kind::quantity,
             .dimension = Dimension::time,
             .allowed = waits,
             .otherwise = "never"}};

constexpr std::array<int, 5> asks{exit_refused, exit_not_reached};
constexpr std::array<int, 5> waits_too{exit_refused, exit_not_reached, exit_timed_out};

constexpr std::array commands{
    Command{.name = "status",
            .summary = "Print the state of the bench",
            .arguments = status_arguments,
            .exit_statuses = asks,
            .act = done<status>},
    Command{.name = "set",
            .summary = "Change the drive",
            .details = "Settings that are not given keep their values.",
            .arguments = set_arguments,
            .example = "shakerctl set --gamma 1.5g --phi 35deg",
            .exit_statuses = asks,
            .act = done<set_drive>},
    Command{.name = "identify",
            .summary = "Measure the response of the base to the drive at a low level",
            .exit_statuses = asks,
            .act = done<identify>},
    Command{
        .name = "start",
        .summary = "Start the drive and measure",
        .details = "The bench repeats the measurement until it is stopped, or N times with --measurements N.",
        .arguments = start_arguments,
        .example = "shakerctl start --periods 40 --wait",
        .exit_statuses = asks,
        .act = done<start>},
    Command{.name = "stop",
            .summary = "Ramp the drive down softly",
            .arguments = stop_arguments,
            .exit_statuses = asks,
            .act = done<stop>},
    Command{.name = "middle",
            .summary = "Bring the walker to the middle of the picture",
            .details =
                "A drive of at least 1 g at phi 0 or 180 deg leads it there from rest, also from beyond "
                "the limit at the edge; then the bench is idle. The set-point stays. The order is refused "
                "while it is not certain that the walker goes inwards.",
            .arguments = middle_arguments,
            .example = "shakerctl clear && shakerctl middle --wait",
            .exit_statuses = asks,
            .act = done<middle>},
    Command{.name = "reset-walker",
            .summary = "Put the walker of a simulated bench back to the middle of its base",
            .details = "At rest only. The log has a note. A bench with real devices refuses the order.",
            .example = "shakerctl clear && shakerctl reset-walker",
            .exit_statuses = asks,
            .act = done<reset_walker>},
    Command{.name = "mu",
            .summary = "Give the friction coefficient of walker and base",
            .details = "Walks are predicted by it until the measurements give a coefficient.",
            .arguments = mu_arguments,
            .exit_statuses = asks,
            .act = done<give_mu>},
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
    Command{.name = "clear",
            .summary = "Clear a trip or an abort, so that the drive can start again",
            .exit_statuses = asks,
            .act = done<clear>},
    Command{.name = "record",
            .summary = "Switch recording on or off, of the run under way and of the following runs",
            .details =
                "In a run, on starts a file as soon as the drive has settled again, without pictures or with "
                "those of its first second; off completes the file, and the run goes on.",
            .arguments = record_arguments,
            .example = "shakerctl record on --name series-1",
            .exit_statuses = asks,
            .act = done<record>},
    Command{.name = "remark",
            .summary = "Add a remark to the log and to the recording",
            .details = "Without a recording under way, the remark goes into the next one.",
            .arguments = remark_arguments,
            .example = "shakerctl remark \"new paper under the walker\"",
            .exit_statuses = asks,
            .act = done<remark>},
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
