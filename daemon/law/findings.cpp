#include "daemon/law/findings.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/law/point.hpp"
#include "drivers/errors.hpp"
#include "drivers/with_error.hpp"

namespace shaker::law {

namespace {

std::string relative(double x) { return fmt::format("{:.3g} %", 100 * x); }

Budget sorted(const Fit& fit, std::vector<Share> shares) {
    std::erase_if(shares, [](const Share& s) { return !std::isfinite(s.share); });
    std::ranges::stable_sort(shares, [](const Share& a, const Share& b) { return a.share > b.share; });
    Budget budget{.of = fit.name, .shares = std::move(shares), .value = fit.value};
    for (const Share& s : budget.shares) budget.total = std::hypot(budget.total, s.share);
    return budget;
}

// The part of the error of mu that vanishes when the tilt is known.
double by_fitted_tilt(const CoulombFit& fit) { return std::abs(fit.covariance.values[1]) / fit.tilt.error; }

using nlohmann::ordered_json;

/// Findings may be const.
template <class Of>
auto all_fits(Of& f) {
    std::vector<decltype(&f.no_stick)> all{&f.coulomb.mu,   &f.slopes.mu,     &f.no_stick,
                                           &f.coulomb.tilt, &f.gravity_tilt,  &f.coulomb.push,
                                           &f.slopes.tilt,  &f.slopes.viscous};
    for (auto& c : f.cosines) all.insert(all.end(), {&c.amplitude, &c.theta});
    for (auto* list : {&f.nulls, &f.reversals, &f.thresholds})
        for (auto& fit : *list) all.push_back(&fit);
    return all;
}

ordered_json fit_json(const Fit& f) {
    return {{"name", f.name},    {"value", f.value},     {"error", f.error},      {"truth", f.truth},
            {"unit", f.unit},    {"chi2", f.chi2},       {"freedom", f.freedom},  {"points", f.points},
            {"note", f.note},    {"refused", f.refused}, {"gamma_mps2", f.gamma}, {"phi_rad", f.phi},
            {"series", f.series}};
}

void add_covariance(ordered_json& list, const Covariance& c, const Fit& of) {
    if (c.names.empty()) return;
    ordered_json matrix = ordered_json::array();
    const std::size_t n = c.names.size();
    for (std::size_t i = 0; i < n; ++i) {
        matrix.emplace_back(ordered_json::array());
        for (std::size_t k = 0; k < n; ++k) matrix.back().push_back(c.values[i * n + k]);
    }
    list.push_back({{"names", c.names}, {"gamma_mps2", of.gamma}, {"series", of.series}, {"matrix", matrix}});
}

ordered_json points_json(const Findings& f) {
    ordered_json list = ordered_json::array();
    for (std::size_t i = 0; i < f.points.size(); ++i) {
        const AskedDrive& a = f.asked[i];
        const bool fitted = i < f.coulomb.points.size();
        list.push_back({{"campaign", f.points[i].campaign},
                        {"point", f.points[i].number},
                        {"v_D_mps", f.points[i].v_D.value},
                        {"law_v_D_mps", fitted ? f.coulomb.points[i].v_D : NAN},
                        {"z", fitted ? f.coulomb.points[i].z : NAN},
                        {"doubt", f.points[i].doubt},
                        {"asked_drive",
                         {{"v_D_mps", a.v_D.value},
                          {"v_D_se_mps", a.v_D.sigma},
                          {"correction_mps", a.correction},
                          {"model_se_mps", a.model_error},
                          {"reason", a.reason}}}});
    }
    return list;
}

std::string where(const Fit& f) {
    std::string at;
    if (std::isfinite(f.gamma)) at += " at " + in_g(f.gamma);
    if (std::isfinite(f.phi)) at += fmt::format(" at {:.1f} deg", f.phi * 360 / two_pi);
    if (!f.series.empty()) at += " (" + f.series + ")";
    return at;
}

// Unequal friction of the two directions moves v_D of mirror partners as a tilt does: mu (1 -+ d/2) as g sin
// b with d = 2 b/mu. Gravity shows the tilt alone.
Fit tilt_by_gravity(std::span<const Point> points, const CoulombFit& coulomb) {
    Fit fit{.name = "tilt by gravity", .unit = "rad"};
    double sum = 0, error = 0;
    for (const Point& p : points) {
        if (!std::isfinite(p.tilt.value) || !std::isfinite(p.tilt.sigma)) continue;
        ++fit.points;
        sum += p.tilt.value;
        error += p.tilt.sigma;
    }
    if (fit.points == 0) {
        fit.note = "not known: the accelerometer's offset is not calibrated, or its reading has no gravity";
        return fit;
    }
    fit.value = sum / fit.points;
    fit.error = error / fit.points;
    const double off = coulomb.tilt.value - fit.value;
    if (!(std::abs(off) > farthest_from_law * std::hypot(coulomb.tilt.error, fit.error))) return fit;
    fit.note = fmt::format(
        "v_D of mirror partners shows a tilt of {} mrad, gravity {} mrad: friction that is {:.2g} % larger "
        "{} would do that on a level base, or the accelerometer's offset is off by {:.2g} m/s^2",
        with_error(1e3 * coulomb.tilt.value, 1e3 * coulomb.tilt.error),
        with_error(1e3 * fit.value, 1e3 * fit.error), 100 * 2 * std::abs(off) / coulomb.law.mu,
        off > 0 ? "backwards" : "forwards", std::abs(off) * coulomb.law.g);
    return fit;
}

// Where v_D is 0: properties of the walker and the bench, whatever fits them.
void fit_zeros(Findings& f, const CoulombFit& coulomb) {
    f.nulls = null_phases(f.points);
    f.reversals = reversals(f.points, coulomb.known() ? &coulomb.law : nullptr);
}

bool same_quantity(const Fit& a, const Fit& b) {
    const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
    return a.name == b.name && a.series == b.series && same(a.gamma, b.gamma) && same(a.phi, b.phi);
}

// The cosine and Eq. (8) are not the law of any walker: their parameters have no truth.
void add_truth(Findings& f) {
    Findings exact;
    exact.points = f.points;
    for (Point& p : exact.points) {
        if (std::isnan(p.true_v_D)) return;
        p.v_D.value = p.true_v_D;
    }
    fit_zeros(exact, f.coulomb);
    for (Fit* fit : all_fits(f))
        for (const Fit* other : all_fits(std::as_const(exact)))
            if (same_quantity(*fit, *other)) fit->truth = other->value;
}

// Each note once, behind the names of its fits. Notes that differ in their figures count as one.
std::string notes_text(const Findings& f) {
    struct Note {
        std::string words, first, names;
        int count = 0;
        bool differ = false;  // in their figures
    };
    std::vector<Note> notes;
    for (const Fit* fit : all_fits(f)) {
        if (fit->note.empty()) continue;
        std::string words = fit->note;
        std::erase_if(words, [](char c) {
            return std::string_view{"0123456789.+-e"}.find(c) != std::string_view::npos;
        });
        auto known = std::ranges::find(notes, words, &Note::words);
        if (known == notes.end()) known = notes.insert(known, {words, fit->note, {}});
        known->differ = known->differ || fit->note != known->first;
        known->names += (known->count++ > 0 ? ", " : "") + fit->name + where(*fit);
    }
    std::string out;
    for (const Note& n : notes)
        out += fmt::format("{}: {}{}\n", n.names, n.first,
                           n.differ ? fmt::format(" ({} times; figures of the first)", n.count) : "");
    return out;
}

}  // namespace

Budget coulomb_budget(std::span<const Point> points, const CoulombFit& fit, const InputErrors& errors) {
    if (!fit.known()) return {.of = fit.mu.name};
    double statistics = 0, harmonics = 0, gain = 0, scale = 0, tilt = 0, gravity = 0, push = 0, turn = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double w = fit.gain[i];
        const LawPoint& at = fit.points[i];
        statistics = std::hypot(statistics, w * points[i].v_D.sigma);
        harmonics = std::hypot(harmonics, w * at.base_error);
        gain += w * at.by_gain;
        scale += w * points[i].v_D.value;
        tilt += w * at.by_tilt;
        gravity += w * at.by_gravity * fit.law.g;
        push += w * at.by_push;
        turn += w * at.by_turn * points[i].turn_told;
    }
    const double mu = fit.law.mu;
    const bool fitted = std::isfinite(fit.tilt.value);
    const double push_error = std::isfinite(fit.push.error) ? fit.push.error : 0;
    const double known = fitted ? by_fitted_tilt(fit) : std::abs(tilt) * errors.tilt;
    // The tilt's part is in both sums already; it is reported apart.
    const double kept = fitted ? std::sqrt(std::max(0.0, 1 - std::pow(known / fit.mu.error, 2))) : 1;
    return sorted(
        fit.mu,
        {{"statistics", kept * statistics / mu, "errors of v_D"},
         {"harmonics", std::hypot(kept * harmonics, push * push_error) / mu,
          fmt::format("errors of the measured harmonics, m/M_eff to {:.2g}", push_error)},
         {"tilt", known / mu,
          fitted ? fmt::format("fitted to {:.2g} urad", 1e6 * fit.tilt.error)
                 : fmt::format("level to {:.2g} mrad, estimate", 1e3 * errors.tilt)},
         {"corner", turn != 0 ? std::abs(turn) / mu : NAN,
          "errors of the accelerometer's high_pass_hz and low_pass_hz"},
         {"gain", std::abs(gain) * errors.gain / mu, relative(errors.gain) + ", estimate"},
         {"scale", std::abs(scale) * errors.scale / mu, relative(errors.scale) + ", estimate"},
         {"clock", 2 * std::abs(scale) * errors.clock / mu, relative(errors.clock) + ", estimate"},
         {"local g", std::abs(gravity) * errors.gravity / mu, relative(errors.gravity) + ", estimate"}});
}

Budget slope_budget(const SlopeFit& fit, const InputErrors& errors) {
    if (!std::isfinite(fit.mu.value)) return {.of = fit.mu.name};
    const double tilt = std::abs(fit.covariance.values[1]) / fit.tilt.error;
    return sorted(
        fit.mu,
        {{"statistics", std::sqrt(std::max(0.0, std::pow(fit.mu.error, 2) - tilt * tilt)) / fit.mu.value,
          "errors of x(t)"},
         {"tilt", tilt / fit.mu.value, fmt::format("fitted to {:.2g} urad", 1e6 * fit.tilt.error)},
         {"gain", 0, "no influence"},
         {"harmonics", 0, "no influence"},
         {"scale", errors.scale, relative(errors.scale) + ", estimate"},
         {"clock", 2 * errors.clock, relative(errors.clock) + ", estimate"},
         {"local g", errors.gravity, relative(errors.gravity) + ", estimate"}});
}

Budget no_stick_budget(const Fit& fit, std::span<const Fit> nulls, const InputErrors& errors) {
    if (!std::isfinite(fit.value)) return {.of = fit.name};
    // mu = gamma sin(Theta/2) / (pi g): one null moves its own mu by cot(Theta/2)/2 of it.
    double statistics = 0;
    for (const Fit& null : nulls) {
        const double half = (null.value - std::numbers::pi / 2) / 2;
        statistics = std::hypot(statistics, null.error / std::tan(half) / 2);
    }
    return sorted(
        fit, {{"model", fit.error / fit.value, "scatter of Theta about Eq. (8)"},
              {"statistics", statistics / static_cast<double>(nulls.size()), "errors of the null phases"},
              {"gain", errors.gain, relative(errors.gain) + ", estimate"},
              {"scale", 0, "no influence"},
              {"clock", 0, "no influence"},
              {"local g", errors.gravity, relative(errors.gravity) + ", estimate"}});
}

AskedDrive on_asked_drive(const Point& point, const LawPoint& at, const CoulombFit& fit) try {
    AskedDrive out;
    if (!fit.known()) {
        out.reason = "mu is not known: " + fit.mu.note;
        return out;
    }
    Point asked = point;
    asked.frequency = point.asked.frequency;
    asked.base = harmonics(point.asked);
    asked.base_sd = {};
    const LawPoint ideal = law_point(asked, Coulomb{.mu = fit.law.mu, .g = fit.law.g});
    out.correction = ideal.v_D - at.v_D;
    const double tilt_error = std::isfinite(fit.tilt.error) ? fit.tilt.error : 0;
    out.model_error =
        std::hypot(at.base_error, (ideal.by_mu - at.by_mu) * fit.mu.error, at.by_tilt * tilt_error);
    const double scale = velocity_scale(point);
    if (std::abs(out.correction) > largest_correction * scale)
        out.reason = fmt::format(
            "the correction of {:.3g} mm/s is {:.2g} % of gamma/omega; at most {:.0f} % is corrected",
            1e3 * out.correction, 100 * std::abs(out.correction) / scale, 100 * largest_correction);
    else if (!(std::abs(at.z) <= farthest_from_law))
        out.reason = fmt::format(
            "the law at the measured base misses v_D by {:.1f} errors; at most {:.0f} are allowed",
            std::abs(at.z), farthest_from_law);
    else
        out.v_D = {point.v_D.value + out.correction, std::hypot(point.v_D.sigma, out.model_error)};
    return out;
} catch (const InputError& error) {
    AskedDrive out;
    out.reason = std::string{"the law has no settled motion on the asked drive: "} + error.what();
    return out;
}

Findings analyse(std::vector<Point> points, const CoulombOptions& options, const InputErrors& errors) {
    Findings f;
    f.points = std::move(points);
    f.gravity = options.g;
    f.coulomb = fit_coulomb(f.points, options);
    f.gravity_tilt = tilt_by_gravity(f.points, f.coulomb);
    f.slopes = fit_slopes(f.points, options.g);
    const bool by_gravity = std::isfinite(f.gravity_tilt.error);
    const Fit& tilt = by_gravity ? f.gravity_tilt : f.coulomb.tilt;
    f.friction = friction_by_velocity(f.points, options.g, {tilt.value, tilt.error},
                                      by_gravity ? "by gravity" : "by mirror partners");
    f.cosines = cosine_fits(f.points);
    fit_zeros(f, f.coulomb);
    f.no_stick = fit_no_stick(f.nulls, f.coulomb.mu.value, options.g);
    f.thresholds = thresholds(f.points, options.g);
    add_truth(f);
    f.budgets = {coulomb_budget(f.points, f.coulomb, errors), slope_budget(f.slopes, errors),
                 no_stick_budget(f.no_stick, f.nulls, errors)};
    for (std::size_t i = 0; i < f.points.size(); ++i) {
        const LawPoint at = f.coulomb.known() ? f.coulomb.points[i] : LawPoint{};
        f.asked.push_back(on_asked_drive(f.points[i], at, f.coulomb));
    }
    return f;
}

Verdict judge(const Findings& f, bool free_tilt) {
    return judge(f.points, CoulombOptions{.g = f.gravity, .free_tilt = free_tilt},
                 {f.gravity_tilt.value, f.gravity_tilt.error});
}

std::string friction_text(const Friction& friction) {
    if (friction.at.empty()) return {};
    std::string text = fmt::format("{:>12}  {:<24} {:>6}\n", "v_R (mm/s)", "mu between the kinks", "pieces");
    for (const FrictionAt& f : friction.at)
        text += fmt::format("{:>12.4g}  {:<24} {:>6}\n", 1e3 * f.v_R, with_error(f.mu.value, f.mu.sigma),
                            f.pieces);
    return text + fmt::format("tilt {} mrad, {}; its error is in each mu\n",
                              with_error(1e3 * friction.tilt.value, 1e3 * friction.tilt.sigma),
                              friction.tilt_from);
}

ordered_json friction_json(const Friction& friction) {
    ordered_json list = ordered_json::array();
    for (const FrictionAt& at : friction.at)
        list.push_back(
            {{"v_R_mps", at.v_R}, {"mu", at.mu.value}, {"mu_error", at.mu.sigma}, {"pieces", at.pieces}});
    return list;
}

ordered_json friction_tilt_json(const Friction& friction) {
    return {{"rad", friction.tilt.value}, {"error", friction.tilt.sigma}, {"from", friction.tilt_from}};
}

std::string findings_text(const Findings& f) {
    std::string out;
    if (f.verdict) {
        const bool coulomb = f.verdict->chosen && !f.verdict->refused && *f.verdict->chosen == 0;
        out = fmt::format("{}.\n{}\n", f.verdict->sentence,
                          coulomb ? "" : "mu_ac is that of Coulomb's law, which the data refuse.\n");
    }
    out += fmt::format("{:<40} {:>28} {:<7} {:>12} {:>7}\n", "fit", "value", "unit", "chi^2/free", "points");
    for (const Fit* fit : all_fits(f)) {
        const std::string chi2 = fit->freedom > 0 && std::isfinite(fit->chi2)
                                     ? fmt::format("{:.3g}", fit->chi2 / fit->freedom)
                                     : "-";
        out += fmt::format("{:<40} {:>28} {:<7} {:>12} {:>7}\n", fit->name + where(*fit),
                           with_error(fit->value, fit->error), fit->unit == "1" ? "" : fit->unit, chi2,
                           fit->points);
    }
    if (f.coulomb.known())
        out += fmt::format(
            "\nThe law at the measured base misses {} of {} points by more than 3 errors; without the "
            "walker's push {}.\n",
            f.coulomb.beyond_3, f.points.size(), f.coulomb.beyond_3_without_push);
    const auto questioned = [](const Point& p) { return !p.doubt.empty(); };
    if (const auto first = std::ranges::find_if(f.points, questioned); first != f.points.end())
        out += fmt::format(
            "\nThe measurements of {} of {} points are in doubt, so is every fit. Point {}: {}\n",
            std::ranges::count_if(f.points, questioned), f.points.size(), first->number, first->doubt);
    for (const Budget& b : f.budgets) {
        if (b.shares.empty()) continue;
        out += fmt::format("\nbudget of {}: {:.3g} % in total, {}\n", b.of, 100 * b.total,
                           with_error(b.value, b.total * b.value));
        for (const Share& s : b.shares)
            out += fmt::format("  {:<12} {:>9.3g} %  {}\n", s.source, 100 * s.share, s.input);
    }
    std::size_t given = 0;
    for (const AskedDrive& a : f.asked) given += a.reason.empty();
    out += fmt::format("\nv_D on the asked drive: given for {} of {} points (--json lists them)\n", given,
                       f.asked.size());
    return out + "\n" + notes_text(f);
}

std::string findings_json(const Findings& f) {
    ordered_json j;
    j["gravity_mps2"] = f.gravity;
    j["fits"] = ordered_json::array();
    for (const Fit* fit : all_fits(f)) j["fits"].push_back(fit_json(*fit));
    j["covariances"] = ordered_json::array();
    add_covariance(j["covariances"], f.coulomb.covariance, f.coulomb.mu);
    add_covariance(j["covariances"], f.slopes.covariance, f.slopes.mu);
    for (const CosineFit& c : f.cosines) add_covariance(j["covariances"], c.covariance, c.amplitude);
    j["budgets"] = ordered_json::object();
    for (const Budget& b : f.budgets) {
        ordered_json& list = j["budgets"][b.of] = ordered_json::array();
        for (const Share& s : b.shares)
            list.push_back({{"source", s.source}, {"share", s.share}, {"input", s.input}});
    }
    j["law"] = {{"beyond_3", f.coulomb.beyond_3},
                {"beyond_3_without_push", f.coulomb.beyond_3_without_push},
                {"chi2_without_push", f.coulomb.chi2_without_push}};
    j["points"] = points_json(f);
    j["friction"] = friction_json(f.friction);
    j["friction_tilt"] = friction_tilt_json(f.friction);
    j["verdict"] = f.verdict ? verdict_json(*f.verdict) : ordered_json{};
    return j.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace shaker::law
