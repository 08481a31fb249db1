#include "daemon/remote/ctl/state_text.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "drivers/drive.hpp"
#include "drivers/text/printable.hpp"
#include "drivers/with_error.hpp"

namespace shaker::ctl {

namespace {

using nlohmann::json;

const json& at(const json& message, const char* path) {
    static const json nothing;
    const json::json_pointer where{path};
    return message.contains(where) ? message.at(where) : nothing;
}

double number(const json& message, const char* path) {
    const json& j = at(message, path);
    return j.is_number() ? j.get<double>() : NAN;
}

std::string word(const json& message, const char* path) {
    const json& j = at(message, path);
    return j.is_string() ? printable(j.get<std::string>()) : std::string{};
}

bool yes(const json& message, const char* path) { return at(message, path) == json(true); }

std::string estimate(const json& state, const std::string& path, double times) {
    return with_error(times * number(state, (path + "/value").c_str()),
                      times * number(state, (path + "/sigma").c_str()));
}

std::string value(double x) { return std::isfinite(x) ? fmt::format("{:.5g}", x) : "-"; }

std::string gamma_text(double gamma) {
    return fmt::format("gamma {} m/s^2 ({} g)", value(gamma), value(gamma / paper_g));
}

std::string phi_text(double phi) {
    return fmt::format("phi {} rad ({} deg)", value(phi), value(phi * 180 / std::numbers::pi));
}

std::string lost_text(const json& state) {
    std::string text;
    for (const json& stream : at(state, "/losses")) {
        const double lost = number(stream, "/lost");
        if (lost > 0)
            text += fmt::format("{}{} of {}", text.empty() ? "" : ", ", lost, word(stream, "/stream"));
    }
    return text.empty() ? "nothing" : text;
}

}  // namespace

std::string state_of(const json& state) { return word(state, "/session/state"); }

std::string trip_of(const json& state) { return word(state, "/session/trip/text"); }

bool has_result(const json& state) { return std::isfinite(number(state, "/result/v_D_mps/value")); }

std::string drift_text(const json& state) {
    const std::string v = estimate(state, "/result/v_D_mps", 1e3);
    if (v == "-") return "v_D -";
    const bool old = at(state, "/result/current") == json(false);
    return "v_D " + v + " mm/s" + (old ? " (of an earlier set-point)" : "");
}

std::string state_text(const json& s) {
    std::string text;
    const auto line = [&](const char* name, const std::string& what) {
        text += fmt::format("{:<11}{}\n", name, what);
    };
    line("state", fmt::format("{}, for {:.0f} s", state_of(s), number(s, "/session/since_s")));
    if (const std::string trip = trip_of(s); !trip.empty())
        line("stopped",
             trip + (yes(s, "/session/may_clear") ? "; may be cleared" : "; may not be cleared yet"));
    line("rig",
         word(s, "/session/rig") + (yes(s, "/session/identified") ? ", identified" : ", not identified"));
    line("drive",
         fmt::format("{} Hz, {}, rho {}, {}{}{}", value(number(s, "/drive/frequency_hz")),
                     gamma_text(number(s, "/drive/gamma_mps2")), value(number(s, "/drive/rho")),
                     phi_text(number(s, "/drive/phi_rad")), yes(s, "/drive/locked") ? ", locked" : "",
                     at(s, "/drive/overtones").empty() ? "" : ", with overtones"));
    if (std::isfinite(number(s, "/measured/gamma_mps2")))
        line("measured",
             gamma_text(number(s, "/measured/gamma_mps2")) + ", " + phi_text(number(s, "/measured/phi_rad")));
    if (has_result(s))
        line("result", fmt::format("{}, D {} mm, efficiency {}", drift_text(s),
                                   estimate(s, "/result/D_m", 1e3), estimate(s, "/result/efficiency", 1)));
    if (yes(s, "/campaign/active"))
        line("campaign", fmt::format("{}, {}: {:.0f} of {:.0f} points have ended", word(s, "/campaign/name"),
                                     word(s, "/campaign/doing"), number(s, "/campaign/ended"),
                                     number(s, "/campaign/points")));
    const std::string file = word(s, "/session/recording"), holder = word(s, "/session/controller");
    const bool finishing = yes(s, "/session/finishing");
    line("recording", file.empty() ? std::string{"none"} : file + (finishing ? ", is being completed" : ""));
    const std::string next = word(s, "/session/record_name");
    line("next run", !yes(s, "/session/record_next") ? "is not recorded"
                     : next.empty()                  ? "is recorded"
                                                     : "is recorded as " + next + ".nxs");
    line("control", holder.empty() ? std::string{"free"} : "held by " + holder);
    line("lost", lost_text(s));
    line("disk", fmt::format("{} GB free", value(1e-9 * number(s, "/disk/free_bytes"))));
    return text;
}

std::string state_line(const json& s) {
    const double got = number(s, "/measured/gamma_mps2");
    const bool measured = std::isfinite(got);
    return fmt::format("{:<11}  {} Hz  {} gamma {} m/s^2  phi {} rad  {}", state_of(s),
                       value(number(s, "/drive/frequency_hz")), measured ? "measured" : "asked",
                       value(measured ? got : number(s, "/drive/gamma_mps2")),
                       value(number(s, measured ? "/measured/phi_rad" : "/drive/phi_rad")), drift_text(s));
}

std::string event_text(const json& e) {
    return fmt::format("at {:.3f} s  {}: {}", number(e, "/t_s"), word(e, "/kind"), word(e, "/text"));
}

}  // namespace shaker::ctl
