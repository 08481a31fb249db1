#include "daemon/commands/predict.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/reduction/no_stick.hpp"
#include "drivers/errors.hpp"
#include "drivers/simulated/walker/steady_state.hpp"

namespace shaker::commands {

namespace {

struct Prediction {
    simulated::SteadyState settled;
    double v_rms = 0;
    double efficiency = 0;      // NaN for a base at rest
    reduction::NoStick closed;  // its reason includes effects that the closed form does not contain
    double theta_coulomb = 0;   // NaN when not applicable
};

/// The walker's effect that the closed form does not contain; empty without one.
std::string beyond_closed_form(const simulated::WalkerSetting& s, const reduction::NoStick& closed) {
    if (s.tilt != 0) return "only for a level base";
    if (s.friction.viscous != 0) return "only for dry friction";
    if (s.friction.mu_s == s.friction.mu_k) return {};
    const double hold = s.friction.mu_s * s.g, start = two_pi * closed.t0;
    const bool passes = value_at(s.base, start) > hold && value_at(s.base, start + std::numbers::pi) < -hold;
    return passes ? "" : "with this mu_s the walker sticks at t0 or t0 + T/2";
}

Prediction predicted(const PredictOptions& o) {
    const simulated::WalkerSetting setting{.frequency = o.drive.frequency,
                                           .base = harmonics(o.drive),
                                           .vertical = {},
                                           .tilt = o.tilt,
                                           .g = o.g,
                                           .friction = o.friction};
    const simulated::WalkerLaw law{setting};
    Prediction p;
    p.settled = settle(law, o.v_start);
    p.v_rms = reduction::v_rms(setting.base, setting.frequency);
    p.efficiency = std::abs(p.settled.v_D) / p.v_rms;
    p.closed = reduction::no_stick(setting.base, setting.frequency, o.friction.mu_k, o.g);
    if (p.closed.valid) {
        p.closed.reason = beyond_closed_form(setting, p.closed);
        p.closed.valid = p.closed.reason.empty();
    }
    const bool coulomb = o.drive.rho == 0.5 && o.tilt == 0 && o.friction.viscous == 0 &&
                         o.friction.mu_s == o.friction.mu_k && o.friction.mu_k > 0;
    p.theta_coulomb =
        coulomb ? reduction::coulomb_theta(o.drive.gamma / (o.friction.mu_k * o.g)) : std::nan("");
    return p;
}

nlohmann::ordered_json number(double x) { return std::isfinite(x) ? nlohmann::ordered_json(x) : nullptr; }

nlohmann::ordered_json events_json(const simulated::SteadyState& s) {
    auto list = nlohmann::ordered_json::array();
    for (const simulated::WalkerEvent& e : s.events) {
        list.push_back({e.phase, static_cast<int>(e.from), static_cast<int>(e.to)});
    }
    return list;
}

std::string as_json(const PredictOptions& o, const Prediction& p) {
    auto stick = nlohmann::ordered_json::array();
    for (const simulated::RestInterval& r : p.settled.rest) stick.push_back({r.from, r.to});
    nlohmann::ordered_json j;
    j["v_D_mps"] = p.settled.v_D;
    j["D_m"] = p.settled.D;
    j["frequency_hz"] = o.drive.frequency;
    j["gamma_mps2"] = o.drive.gamma;
    j["rho"] = o.drive.rho;
    j["phi_rad"] = o.drive.phi;
    j["efficiency"] = number(p.efficiency);
    j["v_rms_mps"] = p.v_rms;
    j["v0_mps"] = p.settled.v0;
    j["stick"] = stick;
    j["events"] = events_json(p.settled);
    j["periods_to_settle"] = p.settled.periods;
    j["contraction"] = p.settled.contraction;
    j["closed_form"] = {{"valid", p.closed.valid},
                        {"reason", p.closed.reason},
                        {"v_D_mps", number(p.closed.v_D)},
                        {"efficiency", number(p.closed.efficiency)},
                        {"t0", number(p.closed.t0)},
                        {"theta_rad", number(p.closed.theta)},
                        {"theta_coulomb_rad", number(p.theta_coulomb)}};
    return j.dump(1) + "\n";
}

const char* name_of(simulated::Contact contact) {
    switch (contact) {
        case simulated::Contact::backward:
            return "slips backward";
        case simulated::Contact::forward:
            return "slips forward";
        case simulated::Contact::stick:
            break;
    }
    return "sticks";
}

std::string angle(double rad) {
    return std::isnan(rad) ? "does not apply"
                           : fmt::format("{:.5f} rad ({:.3f} deg)", rad, rad * 360 / two_pi);
}

std::string closed_form_text(const Prediction& p) {
    std::string text = "closed form without stick (an approximation to the above)\n";
    if (std::isnan(p.closed.v_D)) {
        text += "  v_D             none\n";
    } else {
        text += fmt::format("  v_D             {:.6g} mm/s, efficiency {:.4f}\n", 1e3 * p.closed.v_D,
                            p.closed.efficiency);
        text += fmt::format("  t0              {:.6f} T\n", p.closed.t0);
    }
    text += p.closed.valid ? "  exact here      yes: two slips of T/2\n"
                           : fmt::format("  exact here      no: {}\n", p.closed.reason);
    text += fmt::format("  Theta           {}\n", angle(p.closed.theta));
    return text +
           fmt::format("  Theta, exact    {} (null phase of Coulomb friction with stick, less 90 deg)\n",
                       angle(p.theta_coulomb));
}

std::string as_text(const PredictOptions& o, const Prediction& p) {
    const simulated::SteadyState& s = p.settled;
    std::string text = fmt::format(
        "drive             {:.6g} Hz, gamma {:.6g} m/s^2 ({:.4g} g), rho {:.4g}, phi {:.6g} rad\n",
        o.drive.frequency, o.drive.gamma, o.drive.gamma / o.g, o.drive.rho, o.drive.phi);
    text += fmt::format(
        "walker            mu_k {:.4g}, mu_s {:.4g}, viscous {:.4g} /s, tilt {:.4g} rad, starts at {:.4g} "
        "m/s\n",
        o.friction.mu_k, o.friction.mu_s, o.friction.viscous, o.tilt, o.v_start);
    text += fmt::format("v_D               {:.6g} mm/s\n", 1e3 * s.v_D);
    text += fmt::format("D                 {:.6g} um a period\n", 1e6 * s.D);
    text += std::isnan(p.efficiency) ? "efficiency        none, the base is at rest\n"
                                     : fmt::format("efficiency        {:.4f} of V_RMS = {:.6g} mm/s\n",
                                                   p.efficiency, 1e3 * p.v_rms);
    text += fmt::format("settled after     {} periods; an error of v is scaled by {:.4g} a period\n",
                        s.periods, s.contraction);
    text += fmt::format("sticks for        {:.4f} of the period", s.rest_fraction);
    for (const simulated::RestInterval& r : s.rest) text += fmt::format(", {:.6f} to {:.6f} T", r.from, r.to);
    text += fmt::format("\nat t = 0          {}, v = {:.6g} mm/s\n", name_of(s.contact0), 1e3 * s.v0);
    for (const simulated::WalkerEvent& e : s.events)
        text += fmt::format("  {:.9f} T     {}\n", e.phase, name_of(e.to));
    return text + closed_form_text(p);
}

}  // namespace

std::string predict(const PredictOptions& options) {
    if (!(options.drive.rho >= 0 && options.drive.rho <= 1)) {
        throw InputError{fmt::format("rho is {}; allowed is 0 to 1", options.drive.rho)};
    }
    if (!(options.drive.gamma >= 0)) {
        throw InputError{fmt::format("gamma is {} m/s^2; allowed is 0 or more", options.drive.gamma)};
    }
    if (!(std::abs(options.v_start) <= 1e4)) {
        throw InputError{
            fmt::format("start velocity is {} m/s; allowed is -10000 to 10000", options.v_start)};
    }
    const Prediction p = predicted(options);
    return options.json ? as_json(options, p) : as_text(options, p);
}

}  // namespace shaker::commands
