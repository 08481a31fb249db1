#include "daemon/remote/ctl/table.hpp"

#include <spdlog/fmt/fmt.h>

#include <cstdlib>

#include "daemon/remote/ctl/completion.hpp"
#include "daemon/remote/ctl/looks.hpp"
#include "daemon/remote/ctl/manual.hpp"
#include "daemon/remote/ctl/orders.hpp"
#include "daemon/remote/ctl/state_text.hpp"
#include "daemon/remote/ctl/terminal.hpp"
#include "drivers/drive_limits.hpp"

namespace shaker::ctl {

namespace {

constexpr Range waits{0, 30 * 86400.0};  // s

Argument flag(const char* name, const char* help) { return {name, "", help}; }

Argument word(const char* name, const char* value, const char* help, std::vector<std::string> words) {
    return {name, value, help, Kind::word, std::move(words)};
}

Argument quantity(const char* name, const char* value, const char* help, Dimension dimension, Range allowed) {
    return {name, value, help, Kind::quantity, {}, dimension, allowed};
}

std::vector<Argument> drive_arguments() {
    return {
        quantity("--gamma", "ACCELERATION", "Amplitude of the base's acceleration, e.g. 1.5g or 14.7m/s^2",
                 Dimension::acceleration, drive_limits.gamma),
        quantity("--phi", "ANGLE", "Phase of the second harmonic, e.g. 35deg or 0.61rad", Dimension::angle,
                 drive_limits.phi),
        quantity("--rho", "SHARE", "Share of the first harmonic", Dimension::ratio, drive_limits.rho),
        quantity("--frequency", "FREQUENCY", "Of the drive, e.g. 20Hz", Dimension::frequency,
                 drive_limits.frequency)};
}

std::vector<Command> rows() {
    return {
        {"status",
         "Say what the bench is at",
         "",
         {flag("--json", "One line of JSON, as the daemon has it")},
         status},
        {"set", "Change the drive", "What is not named stays", drive_arguments(), set_drive},
        {"identify", "Find out at a low level how the base answers to the drive", "", {}, identify},
        {"start",
         "Bring the drive up and measure",
         "The bench measures again and again until it is stopped",
         {{"--periods",
           "N",
           "Drive periods of a measurement [as last]",
           Kind::whole,
           {},
           {},
           {2, most_periods}},
          {"--settle",
           "N",
           "Drive periods of the settled drive before it; 0: until the walker is steady [as last]",
           Kind::whole,
           {},
           {},
           {0, most_settle_periods}},
          flag("--wait", "Until the first measurement is reduced; says its v_D")},
         start},
        {"stop", "Bring the drive down softly", "", {flag("--wait", "Until the bench is idle")}, stop},
        {"abort",
         "Stop the drive at once, whoever holds control",
         "What stopped it must be cleared then",
         {},
         abort},
        {"clear", "Clear what stopped the drive, so that it may be started again", "", {}, clear},
        {"record",
         "Record the runs that follow, or no longer",
         "While nothing is driven",
         {word("SWITCH", "", "on or off", {"on", "off"}),
          {"--name", "NAME", "Of the next recording, without folder or ending [the time]", Kind::text},
          word("--frames", "WHICH", "Pictures to keep: off, region (where targets can be) or full [as last]",
               {"off", "region", "full"})},
         record},
        {"remark",
         "Say something for the log and the recording",
         "Into the recording that grows, else into the next; 1 to 400 bytes",
         {{"TEXT", "", "In quotes: \"new paper under the walker\"", Kind::text}},
         remark},
        {"watch",
         "Say the bench's state and v_D once a second, and every event",
         "It begins with the events that the daemon still keeps, and ends with Ctrl-C or when nobody reads "
         "it. In JSON a state has the points measured so far at first and after each measurement",
         {flag("--json", "A line of JSON for each message of the daemon, ten or more a second"),
          quantity("--seconds", "S", "End after so long", Dimension::time, waits)},
         watch},
        {"fetch",
         "Print what the daemon has, as JSON in SI units, or the metrics as text",
         "The result is the newest measurement with its cycle, points are all measurements that are kept",
         {word("WHAT", "", "state, result, points or metrics", {"state", "result", "points", "metrics"})},
         fetch},
        {"wait",
         "Wait until the bench is in a state",
         "A stop by a limit or an abort ends it too, with exit status 1. A daemon that does not listen yet "
         "has "
         "5 s to begin",
         {word("STATE", "", "Its name, as status says it", {state_words.begin(), state_words.end()}),
          quantity("--timeout", "S", "At most so long, then exit status 75 [for ever]", Dimension::time,
                   waits)},
         wait_for},
        {"completion",
         "Print what makes a shell complete the words of shakerctl",
         "In bash: source <(shakerctl completion bash)",
         {word("SHELL", "", "bash, zsh or fish", {"bash", "zsh", "fish"})},
         [](const Given& given) { print(completion(given.text("SHELL"))); }},
        {"manual", "Print the manual page, for man -l", "", {}, [](const Given&) { print(manual()); }},
    };
}

}  // namespace

std::string Given::text(const std::string& name) const {
    const auto found = texts.find(name);
    return found == texts.end() ? std::string{} : found->second;
}

std::string sentences(const Command& command) {
    return command.help + "." + (command.more.empty() ? "" : " " + command.more + ".");
}

const std::vector<Command>& commands() {
    static const std::vector<Command> table = rows();
    return table;
}

const std::vector<Argument>& common_arguments() {
    static const std::vector<Argument> table{
        {"--at", "URL", fmt::format("Where the daemon is [SHAKERD_URL, else {}]", default_url), Kind::text},
        {"--token-file", "FILE", "The daemon's token, in a file of mode 600 [SHAKERD_TOKEN]", Kind::file},
        flag("--help", "Say what there is and end"),
        flag("--version", "Say the version and end")};
    return table;
}

Link link_of(const Given& given) {
    const auto environment = [](const char* name) {
        const char* value = std::getenv(name);
        return std::string{value == nullptr ? "" : value};
    };
    Link link{.at = {}, .token = {}, .client = client_name()};
    const std::string url = environment("SHAKERD_URL");
    if (given.has("--at"))
        link.at = address_of("--at", given.text("--at"));
    else
        link.at =
            url.empty() ? address_of("the built-in address", default_url) : address_of("SHAKERD_URL", url);
    link.token = given.has("--token-file") ? token_of_file(given.text("--token-file"))
                                           : checked_token("SHAKERD_TOKEN", environment("SHAKERD_TOKEN"));
    return link;
}

}  // namespace shaker::ctl
