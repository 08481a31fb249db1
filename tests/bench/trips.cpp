// Time from a fault to the ramp and to silence, in virtual time: every fault in every state of a run, against
// the allowed times; and from the arrival of a sample beyond a limit.
//   --seeds N (5): noise and times   --fault WORDS (all)
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "tests/bench/table.hpp"
#include "tests/support/safety/fault_cases.hpp"

namespace {

using namespace shaker;

std::string option(int argc, char** argv, const char* name, const char* otherwise) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
    return otherwise;
}

/// Median and largest, ms.
struct Spread {
    double median, worst;
};
Spread spread(std::vector<double> s) {
    std::ranges::sort(s);
    return {1e3 * s[s.size() / 2], 1e3 * s.back()};
}

std::string joined(const std::set<safety::Cause>& causes) {
    std::string all;
    for (const safety::Cause c : causes) all += (all.empty() ? "" : ", ") + std::string{name(c)};
    return all;
}

bench::Row row(const test::FaultCase& fault, run::RunState state, int seeds) {
    std::set<safety::Cause> found;
    std::vector<double> ramps, silences;
    int wrong = 0, went_on = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
        const test::Injected injected = test::inject(fault, state, seed);
        if (!test::complaint(fault, state, injected).empty()) ++wrong;
        if (!injected.run.trip) {
            ++went_on;
            continue;
        }
        found.insert(injected.run.trip->cause);
        ramps.push_back(injected.to_ramp_s());
        silences.push_back(injected.run.largest_V > 0 ? injected.to_silence_s() : 0);
    }
    bench::Row r{{"fault", fault.name}, {"state", name(state)}, {"requirement", fault.requirement}};
    r.push_back({"cause", found.empty() ? "none" : joined(found)});
    r.push_back({"went on", std::to_string(went_on) + " of " + std::to_string(seeds)});
    if (!ramps.empty()) {
        const Spread ramp = spread(ramps), silence = spread(silences);
        const double allowed = test::answer_to(fault, state).silent_within_s;
        r.push_back({"to ramp, median", ramp.median, "ms"});
        r.push_back({"worst to ramp", ramp.worst, "ms"});
        r.push_back({"to silence, median", silence.median, "ms"});
        r.push_back({"worst to silence", silence.worst, "ms"});
        r.push_back({"allowed", 1e3 * allowed, "ms", 5});
    }
    r.push_back({"verdict", wrong == 0 ? "good" : std::to_string(wrong) + " wrong"});
    return r;
}

bench::Row limit_row(int seeds) {
    std::vector<double> ramps, silences;
    for (int seed = 1; seed <= seeds; ++seed) {
        const test::Crossing c = test::cross_limit(seed);
        ramps.push_back(c.to_ramp_s);
        silences.push_back(c.to_silence_s);
    }
    const Spread ramp = spread(ramps), silence = spread(silences);
    return {{"fault", "limit_crossed"},
            {"state", "run"},
            {"requirement", "one block + 1 ms"},
            {"cause", name(safety::Cause::acceleration)},
            {"went on", "0 of " + std::to_string(seeds)},
            {"to ramp, median", ramp.median, "ms"},
            {"worst to ramp", ramp.worst, "ms"},
            {"to silence, median", silence.median, "ms"},
            {"worst to silence", silence.worst, "ms"},
            {"allowed", 1e3 * test::limit_to_silence_s, "ms", 5},
            {"verdict", ramp.worst <= 1e3 * test::limit_to_ramp_s ? "good" : "late"}};
}

}  // namespace

int main(int argc, char** argv) {
    const int seeds = std::max(1, std::atoi(option(argc, argv, "--seeds", "5").c_str()));
    const std::string only = option(argc, argv, "--fault", "");
    bench::Table table;
    if (std::string{"limit_crossed"}.find(only) != std::string::npos) table.add(limit_row(4 * seeds));
    std::vector<test::FaultCase> faults = test::fault_cases();
    faults.insert(faults.end(), test::one_axis_cases().begin(), test::one_axis_cases().end());
    for (const test::FaultCase& fault : faults) {
        if (fault.name.find(only) == std::string::npos) continue;
        for (const run::RunState state : test::lasting_states) table.add(row(fault, state, seeds));
    }
    table.print(argc, argv);
}
