#pragma once
// The shaker, its amplifier and its slide: what a data sheet says of them, and what is wrong with them.
#include <array>
#include <string>

#include "drivers/settings_table.hpp"

namespace shaker {

/// What the maker allows, whatever the load. Peak values, except the stroke.
struct ShakerSheet {
    double max_force_n = 45;
    double stroke_mm = 8;                // peak to peak
    double max_velocity_mps = 1.65;      // assumed
    double max_acceleration_mps2 = 736;  // of the bare table; assumed: 75 g
};

/// What the amplifier holds at its output.
enum class DriveKind { voltage, current };

/// Electrodynamic shaker. The default moving mass, stiffness, damping, R and Bl are those of a B&K 4809 as
/// published in maltekrack/NLtest; its inductance is an assumed 0.5 mH. What a real one has besides (cubic
/// stiffness, a fading field, a slide that rubs, stops) is 0 by default: not there.
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
    double kinetic_friction_n = 0;        // brakes the base with this force while it moves
    double stop_travel_mm = 0;            // the base is free within +- this; 0: no end stops
    double stop_stiffness_npm = 1e6;      // of a stop
    double stop_damping_nspm = 50;        // of a stop, which pushes and never pulls
    DriveKind drive = DriveKind::voltage;
    double amplifier_gain = 10;                // volts or amperes out a volt in
    double amplifier_limit_v = 20;             // clips beyond, voltage drive
    double amplifier_limit_a = 10;             // clips beyond, current drive
    double gain_drift_per_min = 0;             // the gain grows by this share of itself a minute
    std::array<double, 2> high_pass_hz{2, 3};  // AC coupling, two one-pole stages
    ShakerSheet sheet;
};

/// The table [shaker] of a scene, which a rig file has too: the shaker's and the amplifier's data sheet. The
/// key `model` ("B&K 4809", "LDS V203", "Modal Shop 2100E11") sets what is published of that shaker; keys
/// beside it win. Throws InputError with file, line, key and value.
ShakerTruth read_shaker(SettingsTable table);
/// Every number of it, without `model`.
std::string shaker_text(const ShakerTruth& shaker);

}  // namespace shaker
