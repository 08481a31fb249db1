#include "daemon/report/results.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "daemon/reduction/quantities.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/with_error.hpp"

namespace shaker::report {

namespace {

using reduction::Quantity;

constexpr double deg = 180 / std::numbers::pi;

std::string line(const std::string& name, const calibration::Estimate& e, double scale,
                 const std::string& unit) {
    return fmt::format("  {:<22}{:>24} {}\n", name,
                       std::isnan(e.value) ? "not determined" : with_error(scale * e.value, scale * e.sigma),
                       unit);
}

nlohmann::json list_of(const std::vector<recording::RecordedTrip>& trips) {
    nlohmann::json list = nlohmann::json::array();
    for (const recording::RecordedTrip& t : trips)
        list.push_back({{"cause", name(t.trip.cause)},
                        {"value", t.trip.value},
                        {"limit", t.trip.limit},
                        {"unit", unit_of(t.trip.cause)},
                        {"harmonic", t.trip.harmonic},
                        {"time_s", t.at_s},
                        {"stop", t.trip.stop == safety::StopKind::hard ? "hard" : "soft"},
                        {"state", t.state},
                        {"words", text(t)}});
    return list;
}

// Behind a line: the part of the error that the calibrations cause.
std::string with_systematic(std::string text, double error, double scale) {
    if (!std::isfinite(error)) return text;
    text.back() = ';';
    return text + fmt::format(" +- {:.2g} systematic\n", scale * error);
}

std::string line(const Quantity& q, const reduction::Reduction& r) {
    const calibration::Estimate e = q.of(r);
    if (q.words.empty() || (q.when_known && !std::isfinite(e.value))) return {};
    const std::string text = line(std::string{q.words}, e, q.scale, std::string{q.shown});
    return with_systematic(text, q.systematic ? q.systematic(r) : NAN, q.scale);
}

// Accelerometer and cameras compared, and the tilt.
std::string check_text(const reduction::Reduction& r) {
    const reduction::GainRatio& g = r.gain_ratio;
    std::string s = line(reduction::quantity("bench_check"), r);
    if (g.views.size() > 1)
        for (const reduction::ViewRatio& v : g.views)
            s += with_systematic(line("  " + v.view, v.ratio, 1, ""), v.scale_error > 0 ? v.scale_error : NAN,
                                 1);
    s += line("  at 2w over at w", g.second_over_first, 1, "");
    s += line(reduction::quantity("phi_off"), r) + line(reduction::quantity("accelerometer_corner"), r);
    if (!std::isfinite(r.tilt.angle.value)) return s;
    const bool known = std::isfinite(r.tilt.angle.sigma);
    s += line("tilt", {r.tilt.angle.value, known ? r.tilt.angle.sigma : r.tilt.noise}, 1e3, "mrad");
    s.back() = ';';
    if (!known) s += " the accelerometer's offset is not calibrated;";
    const std::string share = known ? with_error(1e3 * r.tilt.v_D.value, 1e3 * r.tilt.v_D.sigma)
                                    : fmt::format("{:.2g}", 1e3 * r.tilt.v_D.value);
    return s + fmt::format(" moves v_D by {} mm/s\n", share);
}

// Each harmonic whose motion across the axis exceeds the noise.
std::string across_text(const reduction::Reduction& r) {
    std::string s;
    for (const reduction::MeasuredHarmonic& h : r.harmonics) {
        const calibration::Transverse& t = h.across;
        if (!(h.amplitude.value > 10 * h.amplitude.sigma && t.share.value > 4 * t.share.sigma)) continue;
        s += line(fmt::format("across, harmonic {}", h.q), t.share, 100, "% of the motion along the axis");
        s.back() = ';';
        s +=
            fmt::format(" {:.3f} % in phase, {:.3f} % in quadrature, along ({:+.2f}, {:+.2f}, {:+.2f})\n",
                        100 * t.in_phase, 100 * t.quadrature, t.direction[0], t.direction[1], t.direction[2]);
    }
    return s;
}

}  // namespace

std::string no_stick_text(double shortest_visible) {
    if (std::isnan(shortest_visible)) return "never";
    if (shortest_visible >= 1) return "not known: too few frames, or slips too short";
    return fmt::format("never for over {:.3f} T", shortest_visible);
}

std::string results_text(const reduction::Reduction& r) {
    std::string s = r.degraded ? "degraded, do not rely on it" : "as measured";
    s += " (+- one standard error):\n";
    for (const Quantity& q : reduction::quantities)
        if (!q.checks) s += line(q, r);
    for (const reduction::MeasuredHarmonic& h : r.harmonics)
        if (h.q > 2 && h.amplitude.value > 3 * h.amplitude.sigma)
            s += line(fmt::format("harmonic {}", h.q), h.amplitude, 100 / r.gamma.value, "% of gamma");
    const auto& u = r.shaker_axis;
    s += fmt::format(
        "  {:<22}{:>24} in sensor axes; {:.2f} deg from the nearest one\n", "shaker's axis",
        fmt::format("({:+.4f}, {:+.4f}, {:+.4f})", u[0], u[1], u[2]),
        deg * std::acos(std::min(1.0, std::max({std::abs(u[0]), std::abs(u[1]), std::abs(u[2])}))));
    s += across_text(r);
    s += check_text(r);
    s += line(reduction::quantity("delay"), r);
    s += line(reduction::quantity("accelerometer_ppm"), r);
    s += line("position residual", {r.fit_residual_x_m.value, NAN}, 1e6, "um rms");
    s += fmt::format("  {:<22}{:>24}\n", "frames used / lost",
                     fmt::format("{} / {}", r.frames, r.frames_lost));
    if (r.frames_doubtful > 0) s += fmt::format("  {:<22}{:>24}\n", "frames in doubt", r.frames_doubtful);
    if (r.stick.empty())
        s += fmt::format("  {:<22}{:>24}\n", "sticks", no_stick_text(r.shortest_visible_stick));
    for (const reduction::StickInterval& k : r.stick)
        s += fmt::format("  {:<22}{:>24} T\n", "sticks",
                         fmt::format("{:.4f} to {:.4f} +- {:.4f}", k.from, k.to, k.sd));
    for (const reduction::Flip& flip : r.flips)
        s += fmt::format("  {:<22}{:>24} T, takes less than {:.2g} ms\n", "next slip from",
                         fmt::format("{:.4f} +- {:.4f}", flip.at, flip.at_sd), 1e3 * flip.below_s);
    for (const std::string& note : r.notes) s += "  note: " + note + "\n";
    return s;
}

std::vector<std::string> notes_on(const std::vector<DeviceReport>& devices) {
    std::vector<std::string> notes;
    for (const auto& [device, what, c] : devices)
        if (c.lost > 0 || c.incidents > 0 || c.reopened > 0)
            notes.push_back(fmt::format("{}: {} {} lost of {}, {} incidents, reopened {} times", device,
                                        c.lost, what, c.taken + c.lost, c.incidents, c.reopened));
    return notes;
}

namespace {

void put_check(const reduction::Reduction& r, nlohmann::json& j) {
    const auto error = [](const calibration::Estimate& e) { return e.sigma; };
    const reduction::GainRatio& g = r.gain_ratio;
    nlohmann::json views = nlohmann::json::array();
    for (const reduction::ViewRatio& v : g.views)
        views.push_back({{"camera", v.view}, {"ratio", v.ratio.value}, {"ratio_se", error(v.ratio)}});
    j["bench_check"] = {{"alarm", g.alarm},
                        {"ratio", g.ratio.value},
                        {"ratio_se", error(g.ratio)},
                        {"ratio_systematic", g.systematic},
                        {"second_over_first", g.second_over_first.value},
                        {"second_over_first_se", error(g.second_over_first)},
                        {"views", views},
                        {"tilt_rad", r.tilt.angle.value},
                        {"tilt_se_rad", error(r.tilt.angle)},
                        {"tilt_v_D_mps", r.tilt.v_D.value},
                        {"tilt_v_D_se_mps", error(r.tilt.v_D)}};
}

}  // namespace

std::string results_json(const reduction::Reduction& r, const std::map<std::string, double>& more,
                         const std::vector<DeviceReport>& devices,
                         const std::vector<recording::RecordedTrip>& trips) {
    nlohmann::json j;
    if (!trips.empty()) j["trips"] = list_of(trips);
    for (const auto& [key, value] : more) j[key] = value;
    for (const Quantity& q : reduction::quantities) {
        if (&q == &reduction::quantity("bench_check")) continue;  // an object, below
        const calibration::Estimate e = q.of(r);
        const auto put = [&](const char* part, double value) {
            j[std::string{q.name}.append(part).append(q.suffix)] = value;
        };
        put("", e.value);
        put("_se", e.sigma);
        if (q.systematic) put("_systematic", q.systematic(r));  // null without a calibration
    }
    put_check(r, j);
    j["shaker_axis"] = r.shaker_axis;
    j["position_residual_m"] = r.fit_residual_x_m.value;
    j["frames"] = r.frames;
    j["frames_lost"] = r.frames_lost;
    j["frames_doubtful"] = r.frames_doubtful;
    j["samples"] = r.samples;
    j["samples_bad"] = r.samples_bad;
    j["degraded"] = r.degraded;
    j["harmonics"] = nlohmann::json::array();
    for (const reduction::MeasuredHarmonic& h : r.harmonics)
        j["harmonics"].push_back({{"q", h.q},
                                  {"amplitude_mps2", h.amplitude.value},
                                  {"amplitude_se_mps2", h.amplitude.sigma},
                                  {"phase_rad", h.phase.value},
                                  {"phase_se_rad", h.phase.sigma},
                                  {"across_mps2", h.across.amplitude.value},
                                  {"across_se_mps2", h.across.amplitude.sigma},
                                  {"across", h.across.share.value},
                                  {"across_se", h.across.share.sigma},
                                  {"across_in_phase", h.across.in_phase},
                                  {"across_quadrature", h.across.quadrature},
                                  {"across_direction", h.across.direction}});
    j["stick"] = nlohmann::json::array();
    j["stick_sd"] = nlohmann::json::array();
    for (const reduction::StickInterval& k : r.stick) {
        j["stick"].push_back({k.from, k.to});
        j["stick_sd"].push_back(k.sd);
    }
    j["shortest_visible_stick"] = r.shortest_visible_stick;
    j["flips"] = nlohmann::json::array();
    for (const reduction::Flip& flip : r.flips)
        j["flips"].push_back({{"at", flip.at},
                              {"at_se", flip.at_sd},
                              {"duration_s", flip.duration.value},
                              {"duration_se_s", flip.duration.sigma},
                              {"below_s", flip.below_s}});
    j["periods"] = nlohmann::json::array();
    for (const reduction::PeriodResult& p : r.periods)
        j["periods"].push_back({{"k", p.k},
                                {"t_s", p.t_s},
                                {"D_m", p.drift.value},
                                {"D_se_m", p.drift.sigma},
                                {"gamma_mps2", p.gamma.value},
                                {"phi_rad", p.phi.value}});
    for (const auto& [device, what, c] : devices)
        j["devices"].push_back({{"device", device},
                                {"what", what},
                                {"taken", c.taken},
                                {"lost", c.lost},
                                {"incidents", c.incidents},
                                {"reopened", c.reopened}});
    j["notes"] = r.notes;
    return json_text(j);
}

std::string trips_json(const std::vector<recording::RecordedTrip>& trips, const std::string& why) {
    return json_text({{"trips", list_of(trips)}, {"not_reduced", why}});
}

std::string speed_difference(const calibration::Estimate& measured, double expected, int digits) {
    const double off = measured.value - expected;
    std::string text = fmt::format("{:+.3f} um/s", 1e6 * off);
    constexpr double negligible = 1e-9;  // m/s: where no error is known
    const double error = std::isfinite(measured.sigma) ? std::abs(measured.sigma) : 0;
    if (std::abs(expected) > std::max(error, negligible))
        text += fmt::format(" = {:+.{}f} %", 100 * off / std::abs(expected), digits);
    return text;
}

}  // namespace shaker::report
