#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "daemon/commands.hpp"
#include "daemon/drive_rig.hpp"
#include "daemon/self_test.hpp"
#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr const char* word(Verdict v) {
    switch (v) {
        case Verdict::good:
            return "ok";
        case Verdict::warning:
            return "look";
        case Verdict::bad:
            return "BAD";
    }
    return "";
}

// Opens the rig and plays the self-test; a device that fails on the way is a finding too.
std::vector<Finding> find(const CheckOptions& options) {
    std::vector<Finding> findings;
    SelfTestPlan plan{.frequency = options.frequency_hz};
    OpenRig bench = open_rig(options.rig, options.scene, World::Pace::lockstep);
    for (const std::string& granted : bench.granted) findings.push_back({Verdict::good, "opened", granted});
    const DacInfo dac = bench.rig.dac->info();
    plan.volts = options.level * dac.full_scale_V;
    for (std::size_t q = 0; q < max_harmonics; ++q)
        plan.response[q] = bench.response(static_cast<double>(q + 1) * plan.frequency);
    Acquisition acquisition{bench.rig, nullptr};
    Output output{dac, plan.frequency, trigger_rate(bench.rig), dac.block_frames};
    SelfTest test{plan, dac.rate_hz};
    spdlog::info("self-test: {:.3g} s of silence, then {} periods of {:.3g} V at {:.4g} and {:.4g} Hz",
                 plan.quiet_s, plan.hold, plan.volts, plan.frequency, 2 * plan.frequency);
    try {
        const Execution execution = drive_rig(
            bench, acquisition, output, false,
            [&](const Take& take, Lanes& lanes) { return test.step(take, lanes.drive); },
            [&] { return test.done(); });
        for (const std::string& refused : execution.refused)
            findings.push_back({Verdict::warning, "real time", refused});
    } catch (const DeviceError& e) {
        findings.push_back({Verdict::bad, "self-test", e.what()});
        return findings;
    }
    std::ranges::move(judge(test, bench.rig, acquisition.take()), std::back_inserter(findings));
    return findings;
}

}  // namespace

bool check(const CheckOptions& options) {
    const std::vector<Finding> findings = find(options);
    const bool sound =
        std::ranges::none_of(findings, [](const Finding& f) { return f.verdict == Verdict::bad; });
    if (options.json) {
        nlohmann::json j{{"sound", sound}, {"findings", nlohmann::json::array()}};
        for (const Finding& f : findings)
            j["findings"].push_back({{"verdict", word(f.verdict)}, {"device", f.device}, {"text", f.text}});
        std::cout << j.dump(2) << "\n";
        return sound;
    }
    for (const Finding& f : findings) fmt::print("{:<5}{}: {}\n", word(f.verdict), f.device, f.text);
    fmt::print("{}\n", sound ? "the bench is fit to run" : "the bench is not fit to run: see BAD above");
    return sound;
}

}  // namespace shaker
