#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "daemon/commands/table.hpp"
#include "daemon/commissioning/commission.hpp"
#include "daemon/loopback/loopback.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/run/runner.hpp"
#include "daemon/run/stop_signals.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr const char* word_for(run::Verdict v) {
    constexpr std::array words{"ok", "look", "BAD"};
    return words.at(static_cast<std::size_t>(v));
}

struct Tested {
    std::vector<run::Finding> findings;
    std::string rig_text;
};

Tested tested(const manual::Values& values) {
    run::RunOptions run;
    run.rig = values.text("--rig");
    run.scene = values.text("--scene");
    run.drive.frequency = values.number("--frequency");
    run::Runner runner{{.run = run}};
    const run::StopSignals signals{runner};
    std::vector<run::Finding> findings;
    if (values.has("--restore-mixer"))
        for (const std::string& set : bench::restore_mixers(runner.bench()))
            findings.push_back({run::Verdict::good, "set back", set});
    if (const std::string why = bench::mixers_off_record(runner.bench()); !why.empty()) {
        if (!values.has("--commission")) throw InputError{why};
        findings.push_back({run::Verdict::warning, "commissioning", why});
    }
    for (const std::string& granted : runner.bench().granted)
        findings.push_back({run::Verdict::good, "opened", granted});
    std::ranges::move(
        runner.check({.frequency = run.drive.frequency,
                      .volts = values.number("--level") * runner.bench().rig.dac->info().full_scale_V}),
        std::back_inserter(findings));
    return {findings, runner.bench().rig_text};
}

// The operator sees it at once, also through a pipe.
void show(const std::string& text) {
    report::say(text);
    std::fflush(stdout);
}

// The operator's answer on standard input.
std::string answer_to(const std::string& question) {
    show(question);
    std::string answer;
    std::getline(std::cin, answer);
    report::say("\n");
    return answer;
}

// A cable in the place of amplifier, shaker and sensor.
bool check_cable(const manual::Values& values) {
    const std::string rig_file = values.text("--rig");
    const bool json = values.has("--json");
    if (rig_file == "sim:" || values.has("--commission"))
        throw InputError{"--loopback: needs a rig file of real devices (--rig), and no --commission"};
    const run::StopSignals signals;
    std::vector<std::string> granted;
    Rig rig = loopback::open_sound(rig_file, granted);
    const loopback::Operator person{[json](const std::string& line) {
                                        if (json)
                                            std::fputs(line.c_str(), stderr);
                                        else
                                            show(line);
                                    },
                                    run::StopSignals::rethrow};
    for (const std::string& line : granted) person.say(line + "\n");
    person.say(
        "Switch the amplifier off and connect the drive's output to the sensor's input by a cable. Then "
        "type \"off\": ");
    std::string answer;
    std::getline(std::cin, answer);
    if (answer != "off")
        throw InputError{"--loopback: the answer was \"" + answer + "\", not \"off\"; nothing was played"};
    const loopback::Measured found = loopback::measure(rig, person);
    const double full_V = rig.dac->info().full_scale_V;
    report::say(json ? loopback::json(found, full_V) : loopback::text(found, full_V));
    return true;
}

// Opens every device of a rig, plays a low-level self-test and prints the findings. False when a device is
// not fit to run, or when the commissioning did not pass.
bool check(const manual::Values& values) {
    const bool commission = values.has("--commission"), json = values.has("--json");
    if (commission && (values.text("--rig") == "sim:" || json))
        throw InputError{
            "--commission: needs a rig file of real devices (--rig) and an operator (no --json)"};
    const auto [findings, rig_text] = tested(values);
    const bool sound =
        std::ranges::none_of(findings, [](const run::Finding& f) { return f.verdict == run::Verdict::bad; });
    if (json) {
        nlohmann::json j{{"sound", sound}, {"findings", nlohmann::json::array()}};
        for (const run::Finding& f : findings)
            j["findings"].push_back(
                {{"verdict", word_for(f.verdict)}, {"device", f.device}, {"text", f.text}});
        report::say(report::json_text(j) + "\n");
        return sound;
    }
    for (const run::Finding& f : findings)
        report::say(fmt::format("{:<5}{}: {}\n", word_for(f.verdict), f.device, f.text));
    report::say(sound ? "the bench is fit to run\n" : "the bench is not fit to run: see BAD above\n");
    if (!sound || !commission) return sound;
    const run::StopSignals signals;
    return commissioning::commission({.rig = values.text("--rig"),
                                      .frequency_hz = values.number("--frequency"),
                                      .level = values.number("--level"),
                                      .tested_text = rig_text,
                                      .self_test = fmt::format("{} findings, none bad", findings.size())},
                                     {show, answer_to, run::StopSignals::rethrow});
}

constexpr std::array check_arguments{
    manual::rig_argument,
    manual::scene_argument,
    manual::quantity_option("--frequency", "FREQUENCY", Dimension::frequency, drive_limits.frequency,
                            "Frequency of the first of two harmonics, e.g. 20Hz", "20Hz"),
    manual::quantity_option("--level", "SHARE", Dimension::ratio, {0, 0.2},
                            "Amplitude of each harmonic as a share of the DAC's full scale", "0.02"),
    Argument{.name = "--loopback",
             .help = "Instead, with the amplifier off and a cable from the drive's output to the sensor's "
                     "input: gain, delay, corner, noise, distortion and crosstalk of the sound card"},
    Argument{.name = "--restore-mixer",
             .help = "First set the controls of the sound cards as they were at the commissioning"},
    Argument{
        .name = "--commission",
        .help =
            "Then lead the operator through the first day: the record lets run and serve drive the bench"},
    manual::json_argument};

int act_on_check(const manual::Values& values) {
    return (values.has("--loopback") ? check_cable(values) : check(values)) ? manual::exit_ok
                                                                            : manual::exit_device;
}

}  // namespace

manual::Command check_row() {
    return {.name = "check",
            .summary = "Open every device of a rig and test it at low level",
            .details = "A device that fails the test also gives exit status 3.",
            .arguments = check_arguments,
            .example = "shakerd check --rig bench.toml",
            .exit_statuses = {manual::exit_device, manual::exit_tripped, manual::exit_signal},
            .act = act_on_check};
}

}  // namespace shaker::commands
