#pragma once
// shakerd predict: the walker's motion on a drive, from the exact equation of motion and from the paper's
// closed form.
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/walker/walker_setting.hpp"

namespace shaker::commands {

struct PredictOptions {
    Drive drive{};
    std::optional<Harmonics<Acceleration>> base{};  // in place of the harmonics of `drive`
    Harmonics<Acceleration> vertical{};             // a_z
    walker::Friction friction{};
    double tilt = 0;  // rad
    double g = paper_g;
    double v_start = 0;  // velocity at phase 0, m/s; with mu_s > mu_k the settled motion may depend on it
    int periods = 1000;  // averaged where mu changes from period to period or from place to place
    bool json = false;
};

/// Output for one drive, ending with a newline: text, or one JSON object with the keys v_D_mps, v_D_se_mps
/// (of a mean over periods, else null), D_m, frequency_hz, gamma_mps2, rho, phi_rad (of harmonics 1 and 2),
/// harmonics and vertical_harmonics ([q, m/s^2, rad]), law, efficiency, v_rms_mps, v0_mps, stick (intervals
/// of t/T), events (t/T, from, to), periods_to_settle, contraction, not_computed (sentences with reasons) and
/// closed_form {valid, reason, v_D_mps, efficiency, t0, theta_rad, theta_coulomb_rad}. Values that do not
/// exist are null. Throws InputError for parameters outside the walker's range.
std::string predict(const PredictOptions& options);

/// The settled motion of every case of a file {"cases": [{"name", "params": {"f_hz", "g", "mu_k", "mu_s",
/// "tilt_deg", "base_accel": [{"q", "a", "phase"}], "vertical_accel": [...], optional "v_start", "phases": n,
/// and of Friction "law", "viscous", "backward", "log_share", "log_velocity", "presliding", "stribeck"}}]},
/// in SI units and radians, as a JSON object {name: {"v_D", "D", "eta", "v_at_t0", "state_at_t0", "events":
/// [[t/T, from, to]], "v": [of n phases], ...}} and a newline. Numbers carry all the digits of a double.
/// Throws InputError naming file, case and key.
std::string predict_cases(const std::filesystem::path& file);

/// Harmonics of an acceleration as typed by a person, "1:4.9@0,2:0.5g@35deg": order, amplitude and phase
/// against sin(q w t) of each; without @ the phase is 0. Throws InputError that names the option, the item
/// and what is allowed.
Harmonics<Acceleration> parse_harmonics(std::string_view option, std::string_view text);

}  // namespace shaker::commands
