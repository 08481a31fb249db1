#include "tests/orders/plan.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

namespace shaker::orders {

namespace {

using simulated::FaultKind;

constexpr double yaw_deg = 25;     // of the accelerometer on the base
constexpr double at_edge_mm = 44;  // start of a walker near the edge of the picture

constexpr std::array fault_names{
    "open",         "frozen",        "saturated",      "flipped",    "swapped",     "gain",
    "drop",         "silent",        "amplifier_gain", "walker_off", "walker_on",   "underrun",
    "camera_stall", "camera_lose",   "walker_hidden",  "held_back",  "camera_gone", "late",
    "contact_open", "amplifier_off", "disk_full",      "disk_error", "slow_sensor", "slow_cameras",
    "slow_service", "slow_output",   "killed"};
static_assert(fault_names.size() == troubles);

// How often a client does what, in the order of Action.
constexpr std::array<double, actions> weights{8, 16, 5, 7, 5, 12, 4, 6, 3, 3, 3, 3,
                                              4, 3,  3, 3, 4, 2,  2, 5, 1, 0, 0};
constexpr double init_s = 0.1;  // the devices have delivered by then

double settled_s(const Plan& plan) { return 1.2 + plan.buffer_s; }

// The second of a pair of faults comes soon after the first.
void add_faults(Plan& plan, std::mt19937_64& random) {
    std::uniform_real_distribution<double> share{0, 1};
    const int count = static_cast<int>(plan.length_s / 10 * (1 + 4 * share(random)));
    double last_s = 0;
    for (int i = 0; i < count; ++i) {
        const bool paired = last_s > 0 && share(random) < 0.5;
        const double at_s = paired ? std::min(plan.length_s, last_s + 0.6 * share(random) * share(random))
                                   : settled_s(plan) + (plan.length_s - settled_s(plan)) * share(random);
        last_s = at_s;
        const auto what = static_cast<std::size_t>(share(random) * static_cast<double>(troubles));
        const bool of_cameras = what == static_cast<std::size_t>(FaultKind::camera_stall);
        // 5 ms to 1 s; 20 ms to 4 s.
        const double for_s = (of_cameras ? 4 : 1) * 0.005 * std::pow(200.0, share(random));
        plan.faults.push_back({at_s, what, for_s, share(random)});
    }
}

void add_moves(Plan& plan, std::mt19937_64& random) {
    std::uniform_real_distribution<double> share{0, 1};
    std::discrete_distribution<std::size_t> action(weights.begin(), weights.end());
    std::exponential_distribution<double> wait{1.6};
    for (double at_s = settled_s(plan) * share(random); at_s < plan.length_s; at_s += wait(random)) {
        const int client = static_cast<int>(3 * share(random));
        const auto what = static_cast<Action>(action(random));
        plan.moves.push_back({at_s, client, what, share(random)});
        // Operators answer a trip by clear and start, and follow faults by aborts.
        if (what == Action::clear && share(random) < 0.7)
            plan.moves.push_back({at_s + 0.3 * share(random), client, Action::start, share(random)});
    }
    for (const Fault& f : plan.faults)
        if (share(random) < 0.25)
            plan.moves.push_back(
                {f.at_s + 0.3 * share(random), static_cast<int>(3 * share(random)), Action::abort, 0});
}

// Some plans begin badly: orders while the bench starts, a fault then and one during its self-test.
void add_early(Plan& plan, std::mt19937_64& random) {
    std::uniform_real_distribution<double> share{0, 1};
    if (share(random) > 0.2) return;
    const auto any = [&](std::size_t count) {
        return static_cast<std::size_t>(share(random) * static_cast<double>(count));
    };
    for (int i = 0; i < 4; ++i)
        plan.moves.push_back({init_s * share(random), static_cast<int>(any(3)),
                              static_cast<Action>(any(actions)), share(random)});
    plan.faults.push_back({init_s * share(random), any(troubles), 0.2 * share(random), share(random)});
    plan.faults.push_back({init_s + share(random), any(troubles), 0.2 * share(random), share(random)});
}

// Some faults come soon after an order to stop: while the drive comes to rest.
void add_while_stopping(Plan& plan, std::mt19937_64& random) {
    constexpr double stopping_s = 0.1;
    std::uniform_real_distribution<double> share{0, 1};
    for (const Move& m : plan.moves)
        if (m.action == Action::stop && share(random) < 0.2)
            plan.faults.push_back({m.at_s + stopping_s * share(random),
                                   static_cast<std::size_t>(share(random) * static_cast<double>(troubles)),
                                   0.1 * share(random), share(random)});
}

// Some clients go on after the order to end the program.
void add_while_leaving(Plan& plan, std::mt19937_64& random) {
    constexpr double leaving_s = 0.8;
    std::uniform_real_distribution<double> share{0, 1};
    std::discrete_distribution<std::size_t> action(weights.begin(), weights.end());
    if (share(random) > 0.5) return;
    for (int i = 0; i < 8; ++i)
        plan.moves.push_back({plan.length_s + leaving_s * share(random), static_cast<int>(3 * share(random)),
                              static_cast<Action>(action(random)), share(random)});
}

// Some contacts chatter: they open again and again, also after a clear.
void add_chatter(Plan& plan, std::mt19937_64& random) {
    constexpr double open_s = 0.008;
    std::uniform_real_distribution<double> share{0, 1};
    if (share(random) > 0.15) return;
    double at_s = settled_s(plan) + (plan.length_s - settled_s(plan)) * share(random);
    const int client = static_cast<int>(3 * share(random));
    for (int i = static_cast<int>(10 + 40 * share(random)); i > 0; --i) {
        plan.faults.push_back({at_s, static_cast<std::size_t>(FaultKind::contact_open), open_s, 0});
        at_s += 2 * open_s * (1 + share(random));
        if (share(random) < 0.1) plan.moves.push_back({at_s, client, Action::clear, share(random)});
    }
}

// Some clients measure a campaign, and speak to it at any moment.
void add_campaign(Plan& plan, std::mt19937_64& random) {
    constexpr double length_s = 40;
    std::uniform_real_distribution<double> share{0, 1};
    if (share(random) > 0.15) return;
    plan.length_s = length_s;
    plan.frequency_hz = 10 + 40 * share(random);
    std::erase_if(plan.moves, [&](const Move&) { return share(random) < 0.7; });
    std::erase_if(plan.faults, [&](const Fault&) { return share(random) < 0.7; });
    std::exponential_distribution<double> wait{0.4};
    double at_s = settled_s(plan) + share(random);
    plan.moves.push_back({at_s, 2, Action::campaign, share(random)});
    for (at_s += wait(random); at_s < plan.length_s; at_s += wait(random)) {
        const int client = static_cast<int>(3 * share(random));
        constexpr std::array any{Action::word,  Action::word,  Action::word,    Action::stop,
                                 Action::clear, Action::abort, Action::campaign};
        const Action what = any.at(static_cast<std::size_t>(share(random) * any.size()));
        plan.moves.push_back({at_s, client, what, share(random)});
    }
}

// The first kill stays: a program is killed once in a plan.
void keep_one_kill(Plan& plan) {
    std::ranges::stable_sort(plan.faults, {}, &Fault::at_s);
    bool killed = false;
    std::erase_if(plan.faults, [&](const Fault& f) {
        return f.trouble == static_cast<std::size_t>(Trouble::killed) && std::exchange(killed, true);
    });
}

std::string camera_of(const Fault& f) {
    if (f.value > 2. / 3) return {};  // all
    return fmt::format("camera = \"{}\"\n", f.value < 1. / 3 ? "top" : "side");
}

std::string scene_fault(const Fault& f, double from_s) {
    const auto kind = static_cast<FaultKind>(f.trouble);
    std::string text = fmt::format("\n[[fault]]\nwhat = \"{}\"\nat_s = {}\n", fault_names.at(f.trouble),
                                   std::max(0.0, f.at_s - from_s));
    switch (kind) {
        case FaultKind::drop:
            return text + fmt::format("value = {}\n", 1 + static_cast<int>(40 * f.value));
        case FaultKind::underrun:
            return text + fmt::format("value = {}\n",
                                      static_cast<int>(40 * std::pow(1500.0, f.value)));  // to 1.25 s
        case FaultKind::gain:
            return text + fmt::format("for_s = {}\nvalue = {}\n", f.for_s, 0.2 + 2 * f.value);
        case FaultKind::late:
            return text + fmt::format("for_s = {}\nvalue = {}\n", f.for_s, 0.01 * std::pow(100.0, f.value));
        case FaultKind::amplifier_gain:
            return text + fmt::format("value = {}\n", 0.3 + 1.5 * f.value);
        case FaultKind::walker_off:
        case FaultKind::walker_on:
            return text;
        case FaultKind::camera_stall:
        case FaultKind::walker_hidden:
            return text + fmt::format("for_s = {}\n", f.for_s) + camera_of(f);
        case FaultKind::camera_lose:
        case FaultKind::camera_gone:
            return text + camera_of(f);
        default:
            return text + fmt::format("for_s = {}\n", f.for_s);
    }
}

}  // namespace

const char* name_of_trouble(std::size_t trouble) noexcept { return fault_names[trouble]; }

Plan plan_of(std::uint64_t seed) {
    std::mt19937_64 random{seed * 0x9e3779b97f4a7c15ULL + 1};
    std::uniform_real_distribution<double> share{0, 1};
    Plan plan{.seed = seed};
    plan.length_s = seed % 100 == 0 ? 60 : 10 + 4 * share(random);
    plan.frequency_hz =
        std::array{1.0, 10.0, 20.0, 30.0, 50.0, 1000.0}.at(static_cast<std::size_t>(6 * share(random)));
    plan.identifies = share(random) < 0.25;
    plan.buffer_s = share(random) < 0.5 ? 0 : 0.04 * share(random);
    plan.kept_s = share(random) < 0.5 ? plan.buffer_s : 0.5 * plan.buffer_s * share(random);
    plan.at_edge = share(random) < 0.1;
    plan.enable_s = share(random) < 0.2 ? 0.02 + 0.2 * share(random) : 0;
    add_faults(plan, random);
    add_moves(plan, random);
    add_early(plan, random);
    add_while_stopping(plan, random);
    add_while_leaving(plan, random);
    add_chatter(plan, random);
    add_campaign(plan, random);
    keep_one_kill(plan);
    std::ranges::stable_sort(plan.moves, {}, &Move::at_s);
    return plan;
}

std::string scene_of(const Plan& plan, double from_s) {
    // The accelerometer has 32 samples in the shortest period, the cameras two frames.
    std::string scene = fmt::format(
        "seed = {0}\n[dac]\nrate_hz = {1}\nbuffer_s = {2}\nkept_s = {3}\nenable_before_s = {4}\n"
        "[top]\npositions = 1\nframe_rate_hz = {5}\nexposure_s = {6}\n"
        "[side]\npositions = 1\nframe_rate_hz = {5}\nexposure_s = {6}\n"
        "[accelerometer]\nyaw_deg = {7}\nrate_hz = {8}\nlowpass_hz = {9}\n",
        plan.seed % 1000000, fast(plan) ? 48000 : 24000, plan.buffer_s, plan.kept_s, plan.enable_s,
        fast(plan) ? 2000 : 200, fast(plan) ? 5e-5 : 3e-4, yaw_deg, fast(plan) ? 32000 : 4000,
        fast(plan) ? 4000 : 1000);
    if (plan.at_edge) scene += fmt::format("[walker]\nstart_mm = {}\n", at_edge_mm);
    for (const Fault& f : plan.faults)
        if (f.trouble < scene_faults && f.at_s + f.for_s > from_s) scene += scene_fault(f, from_s);
    return scene;
}

double gamma_for(double value, double frequency_hz) {
    constexpr double stroke_limits_hz = 10;
    const double share = std::min(1.0, frequency_hz / stroke_limits_hz);
    return share * share * (2 + 14 * value);
}

std::array<double, 3> shaker_axis() {
    const double yaw = yaw_deg * std::numbers::pi / 180;
    return {std::cos(yaw), -std::sin(yaw), 0};
}

}  // namespace shaker::orders
