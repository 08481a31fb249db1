#include "drivers/simulated/shaker_truth.hpp"

#include <algorithm>
#include <utility>

#include "drivers/simulated/settings_parts.hpp"

namespace shaker::simulated {

namespace {

constexpr Range positive{1e-9, 1e9};

template <class Part>
void visit(Part&& p, ShakerTruth& s) {
    p("moving_mass_kg", s.moving_mass_kg, positive);
    p("base_mass_kg", s.base_mass_kg, {0, 1e3});
    p("stiffness_npm", s.stiffness_npm, {0, 1e9});
    p("cubic_stiffness_npm3", s.cubic_stiffness_npm3, {0, 1e15});
    p("damping_nspm", s.damping_nspm, {0, 1e6});
    p("resistance_ohm", s.resistance_ohm, {0.01, 1e3});
    p("inductance_h", s.inductance_h, {1e-5, 1});
    p("force_factor_npa", s.force_factor_npa, {0.01, 1e3});
    p("force_factor_falloff_pm2", s.force_factor_falloff_pm2, {0, 1e7});
    p("static_friction_n", s.static_friction_n, {0, 1e4});
    p("kinetic_friction_n", s.kinetic_friction_n, {0, 1e4});
    p("stop_travel_mm", s.stop_travel_mm, {0, 1e3});
    p("stop_stiffness_npm", s.stop_stiffness_npm, {1, 1e9});
    p("stop_damping_nspm", s.stop_damping_nspm, {0, 1e6});
    p.choice("drive", s.drive, {"voltage", "current"});
    p("amplifier_gain", s.amplifier_gain, {-1e3, 1e3});
    p("amplifier_limit_v", s.amplifier_limit_v, {0.01, 1e3});
    p("amplifier_limit_a", s.amplifier_limit_a, {0.01, 1e3});
    p("gain_drift_per_min", s.gain_drift_per_min, {-10, 10});
    p("high_pass_1_hz", s.high_pass_hz[0], {0, 1e3});
    p("high_pass_2_hz", s.high_pass_hz[1], {0, 1e3});
    p("max_force_n", s.sheet.max_force_n, positive);
    p("stroke_mm", s.sheet.stroke_mm, positive);
    p("max_velocity_mps", s.sheet.max_velocity_mps, positive);
    p("max_acceleration_mps2", s.sheet.max_acceleration_mps2, positive);
}

enum class Model { bk_4809, lds_v203, modal_shop_2100e11 };

ShakerTruth preset(Model model) {
    ShakerTruth s;
    if (model == Model::lds_v203) {  // Lang and Snyder, Sound & Vibration 2000, as tabulated in eme171 lab 4
        s.moving_mass_kg = 0.0312;
        s.stiffness_npm = 2897;
        s.damping_nspm = 6.85;
        s.resistance_ohm = 1.6;
        s.inductance_h = 0.764e-3;
        s.force_factor_npa = 3.744;
        // The force is published; stroke and velocity are assumed; the acceleration is force / moving mass.
        s.sheet = {
            .max_force_n = 19.6, .stroke_mm = 5, .max_velocity_mps = 1.5, .max_acceleration_mps2 = 628};
    }
    if (model == Model::modal_shop_2100e11) {  // as modelled in sandialabs/sdynpy
        s.moving_mass_kg = 0.44;
        s.stiffness_npm = 1.1e5;
        s.damping_nspm = 9.6;
        s.resistance_ohm = 4;
        s.inductance_h = 0.6e-3;
        s.force_factor_npa = 36;
        // As above.
        s.sheet = {
            .max_force_n = 445, .stroke_mm = 25.4, .max_velocity_mps = 1.5, .max_acceleration_mps2 = 1011};
    }
    return s;
}

}  // namespace

ShakerTruth read_shaker(SettingsTable table) {
    const std::size_t model = table.choice("model", {"B&K 4809", "LDS V203", "Modal Shop 2100E11"}, 0);
    ShakerTruth shaker = preset(static_cast<Model>(model));
    ReadPart part{std::move(table)};
    visit(part, shaker);
    part.table.finish();
    if (shaker.static_friction_n < shaker.kinetic_friction_n && part.table.has("static_friction_n"))
        part.table.fail(
            "static_friction_n",
            fmt::format("{} is below kinetic_friction_n = {}; static friction must be at least as large "
                        "as kinetic",
                        shaker.static_friction_n, shaker.kinetic_friction_n));
    shaker.static_friction_n = std::max(shaker.static_friction_n, shaker.kinetic_friction_n);
    return shaker;
}

std::string shaker_text(const ShakerTruth& shaker) {
    ShakerTruth s = shaker;
    std::string text = "\n[shaker]\n";
    visit(WritePart{text}, s);
    return text;
}

}  // namespace shaker::simulated
