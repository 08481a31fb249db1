#include "daemon/commands/check_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "daemon/commands/stop_signals.hpp"
#include "daemon/commissioning/commission.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/run/runner.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

constexpr const char* word(run::Verdict v) {
    switch (v) {
        case run::Verdict::good:
            return "ok";
        case run::Verdict::warning:
            return "look";
        case run::Verdict::bad:
            return "BAD";
    }
    return "";
}

struct Tested {
    std::vector<run::Finding> findings;
    std::string rig_text;
};

Tested find(const CheckOptions& options) {
    run::RunOptions run;
    run.rig = options.rig;
    run.scene = options.scene;
    run.drive.frequency = options.frequency_hz;
    run::Runner runner{{.run = run}};
    const StopSignals signals{runner};
    std::vector<run::Finding> findings;
    for (const std::string& granted : runner.bench().granted)
        findings.push_back({run::Verdict::good, "opened", granted});
    std::ranges::move(runner.check({.frequency = options.frequency_hz,
                                    .volts = options.level * runner.bench().rig.dac->info().full_scale_V}),
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

}  // namespace

bool check(const CheckOptions& options) {
    if (options.commission && (options.rig == "sim:" || options.json))
        throw InputError{
            "--commission: needs a rig file of real devices (--rig) and an operator (no --json)"};
    const auto [findings, rig_text] = find(options);
    const bool sound =
        std::ranges::none_of(findings, [](const run::Finding& f) { return f.verdict == run::Verdict::bad; });
    if (options.json) {
        nlohmann::json j{{"sound", sound}, {"findings", nlohmann::json::array()}};
        for (const run::Finding& f : findings)
            j["findings"].push_back({{"verdict", word(f.verdict)}, {"device", f.device}, {"text", f.text}});
        report::say(report::json_text(j) + "\n");
        return sound;
    }
    for (const run::Finding& f : findings)
        report::say(fmt::format("{:<5}{}: {}\n", word(f.verdict), f.device, f.text));
    report::say(sound ? "the bench is fit to run\n" : "the bench is not fit to run: see BAD above\n");
    if (!sound || !options.commission) return sound;
    const StopSignals signals;
    return commissioning::commission({.rig = options.rig,
                                      .frequency_hz = options.frequency_hz,
                                      .level = options.level,
                                      .tested_text = rig_text,
                                      .self_test = fmt::format("{} findings, none bad", findings.size())},
                                     {show, answer_to, StopSignals::rethrow});
}

}  // namespace shaker::commands
