#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "daemon/commands/predict.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/changing_walker.hpp"
#include "drivers/walker/no_stick.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::commands {

namespace {

constexpr int skipped_periods = 200;  // before a mean

struct Prediction {
    walker::WalkerSetting setting;
    double v_D = 0, D = 0;
    double v_D_error = 0;  // NaN for a settled motion
    std::optional<walker::SteadyState> settled;
    std::vector<std::string> not_computed;
    double v_rms = 0;
    double efficiency = 0;     // NaN for a base at rest
    walker::NoStick closed;    // its reason includes effects that the closed form does not contain
    double theta_coulomb = 0;  // NaN when not applicable
};

walker::WalkerSetting setting_of(const PredictOptions& o) {
    return {.frequency = o.drive.frequency,
            .base = o.base.value_or(harmonics(o.drive)),
            .vertical = o.vertical,
            .tilt = o.tilt,
            .g = o.g,
            .friction = o.friction};
}

/// gamma, rho and phi as asked, or of harmonics 1 and 2.
Drive shown_drive(const PredictOptions& o) { return o.base ? drive_of(*o.base, o.drive.frequency) : o.drive; }

/// The walker's effect that the closed form does not contain; empty without one.
std::string beyond_closed_form(const walker::WalkerSetting& s, const walker::NoStick& closed) {
    const walker::Friction& f = s.friction;
    if (s.tilt != 0) return "only for a level base";
    if (s.vertical.order() != 0) return "only without vertical motion";
    if (!f.change.none() || f.roughness.share != 0) return "only for a constant mu";
    if (f.law != walker::FrictionLaw::coulomb || f.viscous != 0) return "only for dry friction";
    if (f.backward != 1) return "only for the same mu in both directions";
    if (f.mu_s == f.mu_k) return {};  // a walker that never sticks does not age either
    const double hold = f.mu_s * s.g, start = two_pi * closed.t0;
    const bool passes = value_at(s.base, start) > hold && value_at(s.base, start + std::numbers::pi) < -hold;
    return passes ? "" : "with this mu_s the walker sticks at t0 or t0 + T/2";
}

/// True for Coulomb's law in the setting for which coulomb_theta() is known.
bool has_coulomb_theta(const walker::WalkerSetting& s) {
    const walker::Friction& f = s.friction;
    const bool biharmonic =
        s.base.order() == 2 &&
        std::abs(std::abs(s.base.at(1)) - std::abs(s.base.at(2))) <= 1e-12 * std::abs(s.base.at(1));
    return biharmonic && s.tilt == 0 && s.vertical.order() == 0 && f.closed_form() && f.change.none() &&
           f.viscous == 0 && f.backward == 1 && f.mu_s == f.mu_k && f.mu_k > 0;
}

void walk(Prediction& p, const PredictOptions& o) {
    const walker::Friction& f = p.setting.friction;
    if (f.change.none() && f.roughness.share == 0) {
        p.settled = settle(p.setting, o.v_start);
        p.v_D = p.settled->v_D;
        p.D = p.settled->D;
        p.v_D_error = std::nan("");
        if (!f.sticks())
            p.not_computed.push_back(
                fmt::format("stick: law {} has no exact stick; its events are the zeros of v_R",
                            walker::friction_laws[static_cast<std::size_t>(f.law)]));
        return;
    }
    const walker::MeanWalk mean = mean_walk(p.setting, o.v_start, skipped_periods, o.periods);
    p.v_D = mean.v_D;
    p.D = mean.v_D / o.drive.frequency;
    p.v_D_error = mean.v_D_error;
    p.not_computed.push_back(
        fmt::format("cycle, stick and events: no two periods are equal, as mu changes; v_D is the mean of {} "
                    "periods after {}",
                    o.periods, skipped_periods));
}

Prediction predicted(const PredictOptions& o) {
    Prediction p;
    p.setting = setting_of(o);
    walk(p, o);
    p.v_rms = walker::v_rms(p.setting.base, p.setting.frequency);
    p.efficiency = std::abs(p.v_D) / p.v_rms;
    p.closed = walker::no_stick(p.setting.base, p.setting.frequency, o.friction.mu_k, o.g);
    if (p.closed.valid) {
        p.closed.reason = beyond_closed_form(p.setting, p.closed);
        p.closed.valid = p.closed.reason.empty();
    }
    p.theta_coulomb = has_coulomb_theta(p.setting)
                          ? walker::coulomb_theta(shown_drive(o).gamma / (o.friction.mu_k * o.g))
                          : std::nan("");
    return p;
}

nlohmann::ordered_json events_json(const walker::SteadyState& s) {
    auto list = nlohmann::ordered_json::array();
    for (const walker::WalkerEvent& e : s.events) {
        list.push_back({e.phase, static_cast<int>(e.from), static_cast<int>(e.to)});
    }
    return list;
}

nlohmann::ordered_json harmonics_json(const Harmonics<Acceleration>& h) {
    auto list = nlohmann::ordered_json::array();
    for (int q = 1; q <= h.order(); ++q)
        if (h.at(q) != 0.0) list.push_back({q, std::abs(h.at(q)), std::arg(h.at(q))});
    return list;
}

void add_cycle(nlohmann::ordered_json& j, const walker::SteadyState& s) {
    auto stick = nlohmann::ordered_json::array();
    for (const walker::RestInterval& r : s.rest) stick.push_back({r.from, r.to});
    j["v0_mps"] = s.v0;
    j["stick"] = stick;
    j["events"] = events_json(s);
    j["periods_to_settle"] = s.periods;
    j["contraction"] = s.contraction;
}

std::string as_json(const PredictOptions& o, const Prediction& p) {
    const Drive drive = shown_drive(o);
    nlohmann::ordered_json j;
    j["v_D_mps"] = p.v_D;
    j["v_D_se_mps"] = p.v_D_error;
    j["D_m"] = p.D;
    j["frequency_hz"] = drive.frequency;
    j["gamma_mps2"] = drive.gamma;
    j["rho"] = drive.rho;
    j["phi_rad"] = drive.phi;
    j["harmonics"] = harmonics_json(p.setting.base);
    j["vertical_harmonics"] = harmonics_json(p.setting.vertical);
    j["law"] = walker::friction_laws[static_cast<std::size_t>(o.friction.law)];
    j["efficiency"] = p.efficiency;
    j["v_rms_mps"] = p.v_rms;
    if (p.settled)
        add_cycle(j, *p.settled);
    else
        for (const char* key : {"v0_mps", "stick", "events", "periods_to_settle", "contraction"})
            j[key] = nullptr;
    j["not_computed"] = p.not_computed;
    j["closed_form"] = {{"valid", p.closed.valid},
                        {"reason", p.closed.reason},
                        {"v_D_mps", p.closed.v_D},
                        {"efficiency", p.closed.efficiency},
                        {"t0", p.closed.t0},
                        {"theta_rad", p.closed.theta},
                        {"theta_coulomb_rad", p.theta_coulomb}};
    return j.dump(1) + "\n";
}

const char* name_of(walker::Contact contact) {
    constexpr std::array names{"slips backward", "sticks", "slips forward"};  // backward is -1
    return names.at(static_cast<std::size_t>(static_cast<int>(contact) + 1));
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

std::string harmonics_text(const Harmonics<Acceleration>& h) {
    std::string text;
    for (int q = 1; q <= h.order(); ++q)
        if (h.at(q) != 0.0)
            text += fmt::format("{}{}: {:.6g} m/s^2 at {:.6g} rad", text.empty() ? "" : ", ", q,
                                std::abs(h.at(q)), std::arg(h.at(q)));
    return text.empty() ? "none" : text;
}

std::string drive_text(const PredictOptions& o) {
    std::string text;
    if (o.base)
        text = fmt::format("drive             {:.6g} Hz, harmonics {}\n", o.drive.frequency,
                           harmonics_text(*o.base));
    else
        text = fmt::format(
            "drive             {:.6g} Hz, gamma {:.6g} m/s^2 ({:.4g} g), rho {:.4g}, phi {:.6g} rad\n",
            o.drive.frequency, o.drive.gamma, o.drive.gamma / o.g, o.drive.rho, o.drive.phi);
    if (o.vertical.order() > 0)
        text += fmt::format("vertical motion   harmonics {}\n", harmonics_text(o.vertical));
    return text;
}

std::string friction_text(const walker::Friction& f) {
    using walker::FrictionLaw;
    std::string text;
    if (f.backward != 1) text += fmt::format(", backward mu_k {:.4g}", f.mu_k * f.backward);
    if (f.law == FrictionLaw::logarithmic)
        text += fmt::format(", strengthening {:.4g} above {:.4g} m/s", f.log_share, f.log_velocity);
    if (!f.sticks()) text += fmt::format(", presliding {:.4g} m", f.presliding);
    if (f.law == FrictionLaw::stribeck || f.law == FrictionLaw::lugre)
        text += fmt::format(", Stribeck velocity {:.4g} m/s", f.stribeck);
    if (f.law == FrictionLaw::lugre) text += fmt::format(", bristle time {:.4g} s", f.bristle_time);
    if (f.ageing != 0) text += fmt::format(", ageing {:.4g} with {:.4g} s", f.ageing, f.ageing_s);
    if (f.roughness.share != 0)
        text += fmt::format(", roughness {:.4g} over {:.4g} m", f.roughness.share, f.roughness.length);
    if (f.change.jitter != 0)
        text += fmt::format(", jitter {:.4g} with memory {:.4g}", f.change.jitter, f.change.memory);
    if (f.change.relaxation != 0)
        text += fmt::format(", relaxation {:.4g} in {:.4g} s", f.change.relaxation, f.change.relaxation_s);
    return fmt::format("law               {}{}\n", walker::friction_laws[static_cast<std::size_t>(f.law)],
                       text);
}

std::string cycle_text(const walker::SteadyState& s, bool sticks) {
    std::string text =
        fmt::format("settled after     {} periods; an error of v is scaled by {:.4g} a period\n", s.periods,
                    s.contraction);
    if (sticks) {
        text += fmt::format("sticks for        {:.4f} of the period", s.rest_fraction);
        for (const walker::RestInterval& r : s.rest)
            text += fmt::format(", {:.6f} to {:.6f} T", r.from, r.to);
        text += "\n";
    }
    text += fmt::format("at t = 0          {}, v = {:.6g} mm/s\n", name_of(s.contact0), 1e3 * s.v0);
    for (const walker::WalkerEvent& e : s.events)
        text += fmt::format("  {:.9f} T     {}\n", e.phase, name_of(e.to));
    return text;
}

std::string as_text(const PredictOptions& o, const Prediction& p) {
    std::string text = drive_text(o);
    text += fmt::format(
        "walker            mu_k {:.4g}, mu_s {:.4g}, viscous {:.4g} /s, tilt {:.4g} rad, starts at {:.4g} "
        "m/s\n",
        o.friction.mu_k, o.friction.mu_s, o.friction.viscous, o.tilt, o.v_start);
    text += friction_text(o.friction);
    text += p.settled
                ? fmt::format("v_D               {:.6g} mm/s\n", 1e3 * p.v_D)
                : fmt::format("v_D               {:.6g} +- {:.2g} mm/s\n", 1e3 * p.v_D, 1e3 * p.v_D_error);
    text += fmt::format("D                 {:.6g} um a period\n", 1e6 * p.D);
    text += std::isnan(p.efficiency) ? "efficiency        none, the base is at rest\n"
                                     : fmt::format("efficiency        {:.4f} of V_RMS = {:.6g} mm/s\n",
                                                   p.efficiency, 1e3 * p.v_rms);
    if (p.settled) text += cycle_text(*p.settled, o.friction.sticks());
    for (const std::string& what : p.not_computed) text += fmt::format("not computed      {}\n", what);
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
    if (options.periods < 16)
        throw InputError{fmt::format("periods is {}; allowed is 16 or more", options.periods)};
    const Prediction p = predicted(options);
    return options.json ? as_json(options, p) : as_text(options, p);
}

}  // namespace shaker::commands
