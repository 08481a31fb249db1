// The cases that the control must handle, by name.
#include <cmath>
#include <utility>

#include "tests/support/control/control_bench.hpp"

namespace shaker::test {

namespace {

simulated::Scene bench_of(const char* model, double base_kg, double walker_kg) {
    simulated::Scene s = simulated::paper_scene();
    SettingsTable table = SettingsTable::from_text(std::string{"model = \""} + model + "\"\n", "model");
    s.shaker = simulated::read_shaker(std::move(table));
    s.shaker.base_mass_kg = base_kg;
    s.walker.mass_kg = walker_kg > 0 ? walker_kg : 1e-6;
    return s;
}

// Cubic stiffness whose force is this share of the linear spring's at the peak excursion of the drive.
double cubic(const simulated::Scene& s, double share, double gamma) {
    const double w = two_pi * 20, peak = 0.5 * gamma / (w * w) * 1.1;
    return share * s.shaker.stiffness_npm / (peak * peak);
}

std::function<void(simulated::ShakerPlant&)> gain(double factor) {
    return [factor](simulated::ShakerPlant& p) { p.set_gain_factor(factor); };
}
std::function<void(simulated::ShakerPlant&)> walker(bool on) {
    return [on](simulated::ShakerPlant& p) { p.set_walker(on); };
}

void add_plants(std::vector<ControlCase>& all, const simulated::Scene& v203,
                const simulated::Scene& carrying) {
    const double g = paper_g;
    all.push_back({.name = "nominal", .scene = v203});
    all.push_back({.name = "no latency", .scene = v203, .latency = 0});
    all.push_back({.name = "latency 4 periods", .scene = v203, .latency = 4});
    all.push_back({.name = "walker 60 g", .scene = carrying});
    const simulated::Scene b4809 = bench_of("B&K 4809", 0.3, 0.06);
    all.push_back({.name = "4809 + 0.3 kg, walker, 1 g", .scene = b4809});
    all.push_back({.name = "4809 + 0.3 kg, walker, 3 g", .scene = b4809, .drive = {.gamma = 3 * g}});
    simulated::Scene s = bench_of("B&K 4809", 0.1, 0.06);
    s.shaker.drive = simulated::DriveKind::current;
    s.shaker.amplifier_gain = 2;
    all.push_back({.name = "4809 + 0.1 kg, f0 = 2 f, current", .scene = s});
    s = v203;
    s.shaker.drive = simulated::DriveKind::current;
    const double w0 = two_pi * 40, mass = s.shaker.moving_mass_kg + s.shaker.base_mass_kg;
    s.shaker.stiffness_npm = mass * w0 * w0;
    s.shaker.damping_nspm = mass * w0 / 40;
    s.shaker.amplifier_gain = 2;
    all.push_back({.name = "resonance on 2 f, Q = 40", .scene = s, .lock_within = 300});
    for (const double gamma : {g, 3 * g}) {
        s = v203;
        s.shaker.cubic_stiffness_npm3 = cubic(s, 0.4, gamma);
        all.push_back({.name = gamma > g ? "cubic 40 %, 3 g" : "cubic 40 %, 1 g",
                       .scene = s,
                       .drive = {.gamma = gamma},
                       .lock_within = 300});
    }
    s = v203;
    s.shaker.static_friction_n = s.shaker.kinetic_friction_n = 0.1 * mass * g;
    all.push_back({.name = "slide's friction 10 %", .scene = s, .lock_within = 300});
    s = carrying;
    s.shaker.cubic_stiffness_npm3 = cubic(s, 0.4, g);
    s.shaker.static_friction_n = s.shaker.kinetic_friction_n = 0.05 * mass * g;
    s.shaker.gain_drift_per_min = 0.1;
    all.push_back({.name = "walker, friction 5 %, cubic 40 %, drift", .scene = s, .lock_within = 300});
}

void add_mistakes(std::vector<ControlCase>& all, const simulated::Scene& v203) {
    all.push_back({.name = "response 5 x too small", .scene = v203, .misjudged = 0.2, .lock_within = 300});
    all.push_back({.name = "response 5 x too large", .scene = v203, .misjudged = 5, .lock_within = 300});
    all.push_back({.name = "response +60 deg",
                   .scene = v203,
                   .misjudged = std::polar(1.0, two_pi / 6),
                   .lock_within = 300});
    all.push_back({.name = "response +100 deg",
                   .scene = v203,
                   .misjudged = std::polar(1.0, two_pi / 3.6),
                   .lock_within = 300});
    all.push_back({.name = "response's sign wrong", .scene = v203, .misjudged = -1, .lock_within = 300});
}

void add_changes(std::vector<ControlCase>& all, const simulated::Scene& v203,
                 const simulated::Scene& carrying) {
    const double g = paper_g;
    simulated::Scene s = v203;
    s.shaker.gain_drift_per_min = 0.1;
    all.push_back({.name = "gain +10 % a minute", .scene = s});
    all.push_back({.name = "gain step x 1.3",
                   .scene = v203,
                   .events = {{.period = 300, .plant = gain(1.3)}},
                   .judged_from = 300});
    all.push_back({.name = "live: 1 -> 1.5 g, phi 0 -> 90 deg, walker",
                   .scene = carrying,
                   .events = {{.period = 300, .drive = Drive{.gamma = 1.5 * g, .phi = two_pi / 4}}},
                   .judged_from = 300});
    all.push_back({.name = "live: 20 -> 25 Hz",
                   .scene = v203,
                   .events = {{.period = 300, .drive = Drive{.frequency = 25}}},
                   .judged_from = 301});
    all.push_back({.name = "walker falls off",
                   .scene = carrying,
                   .events = {{.period = 300, .plant = walker(false)}},
                   .judged_from = 300});
    all.push_back({.name = "walker is put on",
                   .scene = carrying,
                   .events = {{.period = -1, .plant = walker(false)}, {.period = 300, .plant = walker(true)}},
                   .judged_from = 300});
}

void add_limits(std::vector<ControlCase>& all, const simulated::Scene& v203,
                const simulated::Scene& carrying) {
    const double g = paper_g;
    all.push_back({.name = "gamma beyond reach, limit known",
                   .scene = v203,
                   .drive = {.gamma = 4 * g},
                   .volts_limit = 0.22});
    simulated::Scene s = v203;
    s.shaker.amplifier_limit_v = 0.6;
    all.push_back({.name = "amplifier clips, limit unknown", .scene = s, .lock_within = 0, .mean_db = -60});
    s = v203;
    s.accelerometer.mains_hz = 50;
    s.accelerometer.mains_mps2 = 5e-3 * g;
    all.push_back({.name = "50 Hz mains, 5 mg", .scene = s, .mains_hz = 50, .lock_within = 80});
    all.push_back(
        {.name = "rho = 1, 0.5 g, walker", .scene = carrying, .drive = {.gamma = 0.5 * g, .rho = 1}});
    all.push_back({.name = "DAC of 16 bits", .scene = v203, .dac_bits = 16});
    s = v203;
    s.accelerometer.noise_mps2_rthz = 300e-6 * g;
    all.push_back({.name = "sensor of 300 ug/rtHz", .scene = s, .lock_within = 0, .mean_db = -65});
    all.push_back({.name = "gamma = 0.1 g",
                   .scene = v203,
                   .drive = {.gamma = 0.1 * g},
                   .lock_within = 0,
                   .mean_db = -65});
    s = v203;
    s.accelerometer.noise_mps2_rthz = 0;
    all.push_back({.name = "no noise at all", .scene = s});
}

}  // namespace

std::vector<ControlCase> control_cases() {
    const simulated::Scene v203 = bench_of("LDS V203", 0.3, 0), carrying = bench_of("LDS V203", 0.3, 0.06);
    std::vector<ControlCase> all;
    add_plants(all, v203, carrying);
    add_mistakes(all, v203);
    add_changes(all, v203, carrying);
    add_limits(all, v203, carrying);
    return all;
}

}  // namespace shaker::test
