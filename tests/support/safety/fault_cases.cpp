#include "tests/support/safety/fault_cases.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace shaker::test {

namespace {

using enum safety::Cause;
using Answers = std::array<Answer, lasting_states.size()>;

// Times to silence in the safety table, s after the first violating sample.
constexpr double at_once = 0;    // nothing has been driven yet
constexpr double hard = 0.02;    // SAFE-5
constexpr double soft = 0.08;    // SAFE-6, SAFE-9
constexpr double periods = 0.2;  // SAFE-7: faults that need two periods for detection
constexpr double empty = 0.015;  // SAFE-11
// SAFE-4: before a higher level is reached. The first level is reached half a second after the start of the
// drive; each level takes 45 periods; five levels are played for a base that seems to stick.
constexpr double first_windows = 1, first_level = 3.1, all_levels = 11;

Answer trips(std::set<safety::Cause> causes, double within_s) {
    return {Answer::trip, std::move(causes), within_s};
}
Answer may_trip(std::set<safety::Cause> causes, double within_s) {
    return {Answer::trip_or_go_on, std::move(causes), within_s};
}
Answer goes_on() { return {}; }

// The same reaction in every state with a drive.
Answers driven(const Answer& init, const Answer& self_test, const Answer& rest) {
    return {init, self_test, rest, rest, rest, rest};
}
Answers everywhere(const Answer& answer) { return driven(answer, answer, answer); }

FaultCase of_sensor(const char* name, const char* what, const Answers& answers) {
    return {name, fmt::format("what = \"{}\"", what), "SAFE-6", answers, {}};
}
FaultCase of_gain(const char* name, double value, const Answers& answers) {
    return {name, fmt::format("what = \"gain\"\nvalue = {}", value), "SAFE-6", answers, {}};
}
FaultCase of_plant(const char* name, double gain, const Answers& answers) {
    return {name,
            fmt::format("what = \"amplifier_gain\"\nvalue = {}", gain),
            gain > 5 ? "SAFE-5" : "SAFE-6",
            answers,
            {}};
}
FaultCase silence(const char* name, double for_s, const Answers& answers) {
    return {name, fmt::format("what = \"silent\"\nfor_s = {}", for_s), "SAFE-9", answers, {}};
}
FaultCase drop(std::uint64_t samples, const Answers& answers) {
    return {.name = fmt::format("drop_{}", samples),
            .toml = fmt::format("what = \"drop\"\nvalue = {}", samples),
            .requirement = "SAFE-9",
            .answers = answers,
            .missing = samples};
}
FaultCase empty_dac(const char* name, int samples, const Answers& answers,
                    const std::set<safety::Cause>& off) {
    return {name, fmt::format("what = \"underrun\"\nvalue = {}", samples), "SAFE-11", answers, off};
}

void add_sensor(std::vector<FaultCase>& all) {
    all.push_back(of_sensor("open", "open",
                            driven(trips({sensor_open}, first_windows), trips({sensor_open}, at_once),
                                   trips({sensor_open}, soft))));
    const Answer frozen = trips({sensor_frozen}, first_windows);  // at rest the reading may be the same
    all.push_back(of_sensor("frozen", "frozen", driven(frozen, frozen, trips({sensor_frozen}, soft))));
    // Its range exceeds the motion of the base, which one sample cannot show.
    const std::set<safety::Cause> rails{sensor_saturated, acceleration};
    all.push_back(of_sensor("saturated", "saturated",
                            driven(trips({sensor_saturated, acceleration, transverse}, at_once),
                                   trips(rails, at_once), trips(rails, hard))));
    all.push_back(of_sensor("flipped", "flipped",
                            driven(trips({polarity}, first_level), trips({polarity}, at_once),
                                   trips({polarity, residual}, soft))));
    all.push_back(of_sensor("swapped", "swapped",
                            driven(trips({transverse}, first_windows), trips({gravity}, at_once),
                                   trips({gravity, transverse, polarity, residual}, soft))));
    const Answer off_at_rest = trips({gravity}, at_once);
    all.push_back(of_gain("gain_tenth", 0.1,
                          driven(off_at_rest, trips({sensor_open}, at_once), trips({sensor_open}, soft))));
    all.push_back(of_gain("gain_half", 0.5, driven(off_at_rest, off_at_rest, trips({gravity}, soft))));
    all.push_back(of_gain("gain_double", 2, driven(off_at_rest, off_at_rest, trips({gravity}, soft))));
    all.push_back(of_gain("gain_ten", 10,
                          driven(trips({sensor_saturated}, at_once), off_at_rest,
                                 trips({gravity, residual, acceleration}, soft))));
}

// A gain of the loop that nothing shows at rest. Half or double from the start is identified with that gain
// and reported.
Answers unseen_gain(double gain) {
    const Answer weak = trips({gain_limit}, all_levels), strong = trips({gain_limit}, first_level),
                 may_show = may_trip({residual}, 2 * periods);
    if (gain < 0.2)
        return {weak,
                weak,
                trips({sensor_open, residual, gain_limit}, first_level),
                trips({sensor_open, residual}, 2 * periods),
                trips({residual, sensor_open}, periods),
                may_trip({residual, sensor_open}, periods)};
    if (gain < 1)
        return {goes_on(),
                goes_on(),
                goes_on(),
                may_trip({residual}, periods),
                may_trip({residual}, periods),
                may_trip({residual}, periods)};
    if (gain < 5)
        return {goes_on(), goes_on(), may_show, trips({residual}, 2 * periods), trips({residual}, soft),
                may_show};
    return driven(strong, strong, trips({residual, acceleration}, soft));
}

void add_plant(std::vector<FaultCase>& all) {
    for (const auto& [name, gain] :
         {std::pair{"plant_tenth", 0.1}, {"plant_half", 0.5}, {"plant_double", 2.0}, {"plant_ten", 10.0}})
        all.push_back(of_plant(name, gain, unseen_gain(gain)));
    const Answer turned_found = trips({polarity}, first_level);
    const std::set<safety::Cause> turned{polarity, residual};
    all.push_back(of_plant("plant_flipped", -1,
                           {turned_found, turned_found, trips(turned, periods), trips(turned, soft),
                            trips(turned, soft), may_trip(turned, periods)}));
}

void add_gaps(std::vector<FaultCase>& all) {
    const Answer missing = trips({sensor_missing}, soft), before = trips({sensor_missing}, at_once);
    all.push_back(silence("silent", 100, driven({Answer::never_drive}, before, missing)));
    // No samples are missing before the first one.
    all.push_back(silence("silent_for_60_ms", 0.06, driven(goes_on(), before, missing)));
    all.push_back(silence("silent_for_15_ms", 0.015, everywhere(goes_on())));
    all.push_back(drop(1, everywhere(goes_on())));
    all.push_back(drop(60, everywhere(goes_on())));
    all.push_back(drop(90, driven(goes_on(), before, missing)));
    all.push_back(drop(1000, driven(goes_on(), before, missing)));
    const Answer stops = trips({safety::Cause::underrun}, empty),
                 stopped = trips({safety::Cause::underrun}, at_once);
    // An underrun ends a ramp to zero.
    all.push_back(
        empty_dac("underrun", 480,
                  {stopped, stopped, stops, stops, stops, may_trip({safety::Cause::underrun}, empty)}, {}));
    all.push_back(empty_dac("underrun_allowed", 480, everywhere(goes_on()), {safety::Cause::underrun}));
    all.push_back(empty_dac("short_underrun_allowed", 10, everywhere(goes_on()), {safety::Cause::underrun}));
}

// Without gravity a sensor at rest shows only noise: a lost lead, a sign or a gain shows in the drive. A gain
// that is wrong from the start is identified with the response; the cameras find it, or the limits are
// halved.
void add_one_axis(std::vector<FaultCase>& all) {
    const Answer open = trips({sensor_open}, first_windows);
    all.push_back(of_sensor("open", "open", driven(open, open, trips({sensor_open, residual}, soft))));
    const Answer frozen = trips({sensor_frozen}, first_windows);
    all.push_back(of_sensor("frozen", "frozen", driven(frozen, frozen, trips({sensor_frozen}, soft))));
    const std::set<safety::Cause> rails{sensor_saturated, acceleration};
    all.push_back(of_sensor("saturated", "saturated",
                            driven(trips(rails, at_once), trips(rails, at_once), trips(rails, hard))));
    const Answer flipped = trips({polarity}, first_level);
    all.push_back(
        of_sensor("flipped", "flipped", driven(flipped, flipped, trips({polarity, residual}, soft))));
    for (const auto& [name, gain] :
         {std::pair{"gain_tenth", 0.1}, {"gain_half", 0.5}, {"gain_double", 2.0}, {"gain_ten", 10.0}})
        all.push_back(of_gain(name, gain, unseen_gain(gain)));
    const Answer missing = trips({sensor_missing}, soft), before = trips({sensor_missing}, at_once);
    all.push_back(silence("silent", 100, driven({Answer::never_drive}, before, missing)));
    all.push_back(drop(90, driven(goes_on(), before, missing)));
    for (FaultCase& fault : all) fault.one_axis = true;
}

std::string bench(int seed, bool one_axis) {
    return fmt::format("seed = {}\n[accelerometer]\naxis_told = 1\nblock_samples = 10\n{}", seed,
                       one_axis ? "axes = 1\ngravity = 0\nhigh_pass_hz = 0.33\n" : "");
}

// Times at which a run without a fault enters its states.
const VirtualRun& healthy(int seed, bool one_axis) {
    static std::map<std::pair<int, bool>, VirtualRun> runs;
    const std::pair key{seed, one_axis};
    if (!runs.contains(key)) runs[key] = run_virtually({.scene = bench(seed, one_axis)});
    return runs[key];
}

// Time of the fault after the start of the state, s, with another phase of the drive for every seed. In
// ramp_down the base must still move by more than the walker.
double moment(run::RunState state, int seed) {
    const double share = std::fmod(0.381966 * seed, 1);
    switch (state) {
        case run::RunState::init:
            return 0.002 * share;
        case run::RunState::self_test:
            return 0.3 + 0.2 * share;
        case run::RunState::identify:
            return 0.6 + 3 * share;
        case run::RunState::run:
            return 0.2 + 1.2 * share;
        case run::RunState::ramp_down:
            return 0.02 + 0.3 * share;
        default:
            return 0.05 + 0.4 * share;
    }
}

}  // namespace

const std::vector<FaultCase>& fault_cases() {
    static const std::vector<FaultCase> cases = [] {
        std::vector<FaultCase> all;
        add_sensor(all);
        add_plant(all);
        add_gaps(all);
        return all;
    }();
    return cases;
}

const std::vector<FaultCase>& one_axis_cases() {
    static const std::vector<FaultCase> cases = [] {
        std::vector<FaultCase> all;
        add_one_axis(all);
        return all;
    }();
    return cases;
}

const Answer& answer_to(const FaultCase& fault, run::RunState state) {
    const auto at = std::ranges::find(lasting_states, state) - lasting_states.begin();
    return fault.answers.at(static_cast<std::size_t>(at));
}

Injected inject(const FaultCase& fault, run::RunState state, int seed) {
    const VirtualRun& without = healthy(seed, fault.one_axis);
    const double at_s = without.entered_s.at(state) + moment(state, seed);
    const bool shows_at_rest = answer_to(fault, state).silent_within_s == at_once;
    safety::Detectors detectors = safety::all_detectors;
    for (const safety::Cause c : fault.off) detectors.reset(static_cast<std::size_t>(c));
    return {shows_at_rest ? at_s : std::max(at_s, without.entered_s.at(run::RunState::identify)),
            run_virtually({.scene = bench(seed, fault.one_axis) +
                                    fmt::format("[[fault]]\nat_s = {:.6f}\n{}\n", at_s, fault.toml),
                           .detectors = detectors,
                           .longest_s = 30})};
}

std::string complaint(const FaultCase& fault, run::RunState state, const Injected& injected) {
    const Answer& answer = answer_to(fault, state);
    const VirtualRun& run = injected.run;
    if (run.largest_V > 0.951) return fmt::format("{} V were driven, 0.95 are allowed", run.largest_V);
    if (answer.kind == Answer::never_drive) return run.largest_V > 0 ? "something was driven" : "";
    if (run.trip && answer.kind == Answer::go_on) return "a trip: " + text(*run.trip);
    if (!run.trip) {
        if (answer.kind == Answer::trip) return fmt::format("no trip; it ended in state {}", name(run.ended));
        if (run.ended != run::RunState::idle) return fmt::format("it ended in state {}", name(run.ended));
        const auto counted = run.warnings.find(sensor_missing);
        const bool gap_seen = fault.missing == 0 || state == run::RunState::init ||
                              (counted != run.warnings.end() && counted->second == fault.missing);
        return gap_seen ? "" : "the gap was not counted, or wrongly";
    }
    if (!answer.causes.contains(run.trip->cause)) return "not the right reason: " + text(*run.trip);
    if (answer.silent_within_s == at_once) return run.largest_V > 0 ? "something was driven" : "";
    if (injected.to_silence_s() > answer.silent_within_s)
        return fmt::format("silent {:.1f} ms after, {:.0f} are allowed: {}", 1e3 * injected.to_silence_s(),
                           1e3 * answer.silent_within_s, text(*run.trip));
    return "";
}

Crossing cross_limit(int seed) {
    const VirtualRun run = run_virtually(
        {.scene = fmt::format("seed = {}\n[accelerometer]\naxis_told = 1\nblock_samples = 1\nlatency_s = {}\n"
                              "latency_jitter_s = 2e-5\nstart_s = {}\n",
                              seed, 0.0003, 0.0031 + 0.00037 * seed),
         .identify = false,
         .limits = [seed](safety::Limits& l) { l.acceleration.abort = 4 + 0.13 * seed; }});
    if (!run.trip || run.trip->cause != acceleration) return {INFINITY, INFINITY};
    return {run.stop_began_s - run.violated_s(), run.silent_s - run.violated_s()};
}

}  // namespace shaker::test
