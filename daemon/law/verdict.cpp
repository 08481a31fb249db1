#include "daemon/law/verdict.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "daemon/law/least_squares.hpp"
#include "drivers/errors.hpp"
#include "drivers/with_error.hpp"

namespace shaker::law {

namespace {

constexpr double telling_tolerance = 1e-8;  // of the integrator

bool contains(const Law& law, std::string_view name) {
    return std::ranges::find(law.contains, name) != law.contains.end();
}

std::vector<LawFit> fits_of(const LawData& data) {
    std::vector<LawFit> fits;
    for (const Law& law : laws) fits.push_back(fit_law(law, data));
    return fits;
}

// True where a law describes harmonics 9 to 16: nothing else than the walker moves the base there.
bool base_is_the_walkers(std::span<const LawFit> fits) {
    return std::ranges::any_of(fits, [](const LawFit& f) {
        return f.known() && f.freedom_base > 0 && !misfits(f.chi2_base, f.freedom_base);
    });
}

// The drive of these at which v_D of two laws differs most.
std::optional<TellingDrive> telling_drive(const LawFit& a, const LawFit& b, const Point& like) {
    std::optional<TellingDrive> best;
    for (const double gamma : {0.5, 0.7, 1.0, 1.5, 2.0, 3.0})
        for (const double phi : {0.0, 0.25, 0.5, 0.75}) {
            Point p = like;
            p.asked.gamma = gamma * paper_g;
            p.asked.phi = phi * std::numbers::pi;
            p.base = harmonics(p.asked);
            p.frequency = p.asked.frequency;
            try {
                const double apart = law_cycle(p, NAN, a.setting, telling_tolerance).v_D -
                                     law_cycle(p, NAN, b.setting, telling_tolerance).v_D;
                if (!best || std::abs(apart) > std::abs(best->apart)) best = {p.asked, apart};
            } catch (const InputError&) {
                continue;  // no settled motion there
            }
        }
    return best;
}

std::string parameters_text(const LawFit& f) {
    std::string text = "mu " + with_error(f.mu.value, f.mu.error);
    for (const Fit& p : f.parameters) {
        const bool length = p.unit == "m", velocity = p.unit == "m/s";
        const double shown = length ? 1e6 : velocity ? 1e3 : 1;
        const std::string unit = length ? "um" : velocity ? "mm/s" : p.unit == "1" ? "" : p.unit;
        const bool scale = length || velocity || p.unit == "s";  // above 0, fitted as a logarithm
        text += fmt::format(
            ", {} {}", p.name,
            scale && p.error > p.value ? "not known" : with_error(shown * p.value, shown * p.error));
        if (!unit.empty()) text += fmt::format(" {}", unit);
        const LawParameter& range = f.law->parameters[static_cast<std::size_t>(&p - f.parameters.data())];
        if (p.value != range.none &&
            (p.value <= range.low * (1 + 1e-9) || p.value >= range.high * (1 - 1e-9)))
            text += " (the end of its range)";
    }
    return text;
}

// A fit whose search ended above the law that it contains has not found its least chi^2.
void drop_stuck(std::vector<LawFit>& fits) {
    for (LawFit& f : fits)
        for (const LawFit& inner : fits)
            if (f.known() && inner.known() && contains(*f.law, inner.law->name) &&
                f.chi2 + f.chi2_base > inner.chi2 + inner.chi2_base + 1)
                f.reason = fmt::format("the search ended above {}, which it contains", inner.law->words);
}

// What else the numbers of a law may come from.
std::string else_it_may_be(const LawFit& f) {
    if (f.law->needs != Law::Needs::tilt) return {};
    const double tilt = 0.5 * f.mu.value * std::abs(f.parameters.front().value - 1);
    return fmt::format("; an accelerometer's offset that is off by {:.2g} m/s^2 would look the same",
                       tilt * f.setting.g);
}

// Doubtful measurements make doubtful fits.
std::string doubts_text(std::span<const Point> points) {
    const auto doubtful = [](const Point& p) { return !p.doubt.empty(); };
    const auto first = std::ranges::find_if(points, doubtful);
    if (first == points.end()) return {};
    return fmt::format("; the measurements of {} of {} points are in doubt, so is this (point {}: {})",
                       std::ranges::count_if(points, doubtful), points.size(), first->number, first->doubt);
}

std::string sentence_of(const Verdict& v) {
    if (!v.chosen)
        return "no law was fitted: " +
               (v.fits.front().known() ? "too few points for its parameters" : v.fits.front().reason);
    const LawFit& best = v.fits[*v.chosen];
    std::string text;
    if (v.refused) {
        text = fmt::format(
            "no law of the list describes these points; nearest: {}, chi^2 of v_D {:.3g} times its degrees "
            "of freedom",
            best.law->words, best.chi2 / best.freedom);
        if (best.freedom_base > 0)
            text += fmt::format(", of harmonics 9 to 16 {:.3g} times", best.chi2_base / best.freedom_base);
    } else {
        text = fmt::format("{} describes the points: {}{}", best.law->words, parameters_text(best),
                           else_it_may_be(best));
    }
    for (std::size_t i = 0; i < v.rivals.size(); ++i)
        text += fmt::format("{}{} ({})", i > 0 ? ", " : "; these points do not distinguish it from ",
                            v.fits[v.rivals[i]].law->words, parameters_text(v.fits[v.rivals[i]]));
    if (v.measure)
        text += fmt::format(": measure at {}, {:.0f} deg, where they differ by {:.2g} mm/s",
                            in_g(v.measure->drive.gamma), v.measure->drive.phi * 360 / two_pi,
                            1e3 * std::abs(v.measure->apart));
    std::string left_out;
    for (const LawFit& f : v.fits)
        if (!f.known() && (v.refused || f.law->needs != Law::Needs::nothing))
            left_out += (left_out.empty() ? "; not judged: " : ", ") + std::string{f.law->words};
    return text + left_out;
}

void choose(Verdict& v, std::size_t points) {
    const double each = std::log(static_cast<double>(std::max<std::size_t>(points, 2)));
    v.score.assign(v.fits.size(), NAN);
    std::optional<std::size_t> least;
    for (std::size_t i = 0; i < v.fits.size(); ++i) {
        const LawFit& f = v.fits[i];
        if (!f.known() || f.freedom < 1) continue;
        v.score[i] = f.chi2 + f.chi2_base + f.free * each;
        if (!least || v.score[i] < v.score[*least]) least = i;
    }
    if (!least) return;
    const auto as_good = [&](std::size_t i) { return v.score[i] - v.score[*least] < decisive; };
    v.chosen = least;
    for (std::size_t i = 0; i < v.fits.size(); ++i)  // the simplest that the least one contains
        if (as_good(i) && contains(*v.fits[*least].law, v.fits[i].law->name)) {
            v.chosen = i;
            break;
        }
    const LawFit& best = v.fits[*v.chosen];
    v.refused = misfits(best.chi2, best.freedom) || misfits(best.chi2_base, best.freedom_base);
    for (std::size_t i = 0; i < v.fits.size() && !v.refused; ++i)
        if (i != *v.chosen && as_good(i) && !contains(*v.fits[i].law, best.law->name)) v.rivals.push_back(i);
    std::ranges::sort(v.rivals, {}, [&](std::size_t i) { return v.score[i]; });
}

}  // namespace

std::vector<Point> evenly(std::span<const Point> points, std::size_t most) {
    std::map<std::pair<int, int>, std::vector<const Point*>> pairs;
    for (const Point& p : points)
        pairs[{p.campaign, p.partner > 0 ? std::min(p.number, p.partner) : p.number}].push_back(&p);
    std::vector<Point> out;
    std::size_t seen = 0;
    for (const auto& [key, pair] : pairs) {
        if (out.size() * points.size() <= seen * most)
            for (const Point* p : pair) out.push_back(*p);
        seen += pair.size();
    }
    return out;
}

Verdict judge(std::span<const Point> all, const CoulombOptions& options, const calibration::Estimate& tilt) {
    Verdict v;
    const std::vector<Point> points =
        all.size() > most_judged ? evenly(all, most_judged) : std::vector<Point>{all.begin(), all.end()};
    const CoulombFit coulomb = fit_coulomb(points, options);
    LawData data{.points = points,
                 .coulomb = &coulomb,
                 .tilt = options.free_tilt ? tilt : calibration::Estimate{},
                 .free_tilt = options.free_tilt && (shows_tilt(points) || tilt.sigma > 0)};
    for (const Point& p : points) v.points.push_back(p.number);
    v.fits = fits_of(data);
    drop_stuck(v.fits);
    v.harmonics = base_is_the_walkers(v.fits);
    const bool dropped =
        !v.harmonics && std::ranges::any_of(v.fits, [](const LawFit& f) { return f.freedom_base > 0; });
    if (dropped) {
        data.harmonics = false;
        v.fits = fits_of(data);
        drop_stuck(v.fits);
    }
    choose(v, points.size());
    const auto by_drive = [&](std::size_t i) { return v.fits[i].law->needs == Law::Needs::nothing; };
    if (!v.rivals.empty() && by_drive(*v.chosen) && by_drive(v.rivals.front()))
        v.measure = telling_drive(v.fits[*v.chosen], v.fits[v.rivals.front()], points.front());
    v.sentence = sentence_of(v) + doubts_text(points);
    if (dropped) v.sentence += "; harmonics 9 to 16 of the base are not used, since no law describes them";
    if (points.size() < all.size())
        v.sentence += fmt::format(" (judged by {} of {} points)", points.size(), all.size());
    return v;
}

std::string verdict_text(const Verdict& v) {
    if (std::ranges::none_of(v.fits, &LawFit::known)) return v.sentence + "\n";
    std::string text = fmt::format("{:<44} {:>10} {:>8} {:>10} {:>8} {:>10}  {}\n", "law", "chi^2 v_D",
                                   "freedom", "chi^2 9-16", "freedom", "score", "fitted");
    for (std::size_t i = 0; i < v.fits.size(); ++i) {
        const LawFit& f = v.fits[i];
        if (!f.known()) {
            text += fmt::format("{:<44} not fitted: {}\n", f.law->words, f.reason);
            continue;
        }
        text += fmt::format("{:<44} {:>10.4g} {:>8} {:>10.4g} {:>8} {:>10.4g}  {}", f.law->words, f.chi2,
                            f.freedom, f.chi2_base, f.freedom_base, v.score[i], parameters_text(f));
        if (std::isfinite(f.tilt.value))
            text += fmt::format(", tilt {} mrad", with_error(1e3 * f.tilt.value, 1e3 * f.tilt.error));
        text += "\n";
    }
    text +=
        "The errors are those of the points. Those of the sensors' scales, in the budget of \"shakerd mu\", "
        "add to them.\n";
    return text + v.sentence + "\n";
}

nlohmann::ordered_json verdict_json(const Verdict& v) {
    using nlohmann::ordered_json;
    ordered_json list = ordered_json::array();
    for (std::size_t i = 0; i < v.fits.size(); ++i) {
        const LawFit& f = v.fits[i];
        ordered_json parameters = ordered_json::array();
        for (const Fit& p : f.parameters)
            parameters.push_back(
                {{"name", p.name}, {"unit", p.unit}, {"value", p.value}, {"error", p.error}});
        list.push_back({{"name", f.law->name},
                        {"words", f.law->words},
                        {"mu", f.mu.value},
                        {"mu_error", f.mu.error},
                        {"tilt_rad", f.tilt.value},
                        {"tilt_error", f.tilt.error},
                        {"mean_place_m", f.setting.middle},
                        {"parameters", parameters},
                        {"covariance", f.covariance.values},
                        {"chi2", f.chi2},
                        {"freedom", f.freedom},
                        {"chi2_base", f.chi2_base},
                        {"freedom_base", f.freedom_base},
                        {"score", v.score.empty() ? NAN : v.score[i]},
                        {"reason", f.reason},
                        {"z", f.z}});
    }
    ordered_json rivals = ordered_json::array(), measure;
    for (const std::size_t i : v.rivals) rivals.push_back(v.fits[i].law->name);
    if (v.measure)
        measure = {{"gamma_mps2", v.measure->drive.gamma},
                   {"phi_rad", v.measure->drive.phi},
                   {"v_D_apart_mps", v.measure->apart}};
    return ordered_json{{"chosen", v.chosen ? ordered_json(v.fits[*v.chosen].law->name) : ordered_json{}},
                        {"refused", v.refused},
                        {"points", v.points},
                        {"rivals", rivals},
                        {"measure", measure},
                        {"harmonics", v.harmonics},
                        {"sentence", v.sentence},
                        {"laws", list}};
}

}  // namespace shaker::law
