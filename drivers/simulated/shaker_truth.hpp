#pragma once
// Parameters of shaker, amplifier and slide: data sheet and imperfections.
#include <array>
#include <string>

#include "drivers/settings_table.hpp"

namespace shaker::simulated {

/// Limits given by the maker, for any load. Peak values, except the stroke.
struct ShakerSheet {
    double max_force_n = 45;
    double stroke_mm = 8;                // peak to peak
    double max_velocity_mps = 1.65;      // assumed
    double max_acceleration_mps2 = 736;  // of the bare table; assumed: 75 g
};

/// Quantity that the amplifier controls at its output.
enum class DriveKind { voltage, current };

/// Electrodynamic shaker. Default moving mass, stiffness, damping, R and Bl: B&K 4809, as published in
/// maltekrack/NLtest; the inductance of 0.5 mH is assumed. Imperfections (cubic stiffness, falling Bl,
/// friction of the slide, stops) are 0 by default.
struct ShakerTruth {
    double moving_mass_kg = 0.057;
    double base_mass_kg = 0.5;        // table and slide, without the walker
    double stiffness_npm = 9932;      // N/m
    double cubic_stiffness_npm3 = 0;  // spring force k x + k3 x^3
    double damping_nspm = 21.5;       // N s/m
    double resistance_ohm = 2;
    double inductance_h = 0.5e-3;
    double force_factor_npa = 6.78;       // Bl at x = 0
    double force_factor_falloff_pm2 = 0;  // b in Bl(x) = Bl (1 - b x^2), 1/m^2, for |x| well below b^(-1/2)
    double static_friction_n = 0;         // of the slide; holds the base up to this force
    double kinetic_friction_n = 0;        // of the slide while the base moves
    double stop_travel_mm = 0;            // free travel +-; 0: no end stops
    double stop_stiffness_npm = 1e6;      // of a stop
    double stop_damping_nspm = 50;        // of a stop; it never pulls
    DriveKind drive = DriveKind::voltage;
    double amplifier_gain = 10;                // V or A at the output per V at the input
    double amplifier_limit_v = 20;             // clipping level, voltage drive
    double amplifier_limit_a = 10;             // clipping level, current drive
    double gain_drift_per_min = 0;             // relative growth of the gain per minute
    std::array<double, 2> high_pass_hz{2, 3};  // AC coupling, two one-pole stages
    ShakerSheet sheet;
};

/// Reads the table [shaker] of a scene or rig file: data sheet of shaker and amplifier. The key `model` ("B&K
/// 4809", "LDS V203", "Modal Shop 2100E11") sets the published values of that shaker; other keys override
/// them. Throws InputError with file, line, key and value.
ShakerTruth read_shaker(SettingsTable table);
/// All values as TOML, without `model`.
std::string shaker_text(const ShakerTruth& shaker);

}  // namespace shaker::simulated
