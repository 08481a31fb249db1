#include "daemon/campaign/plan_check.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "drivers/errors.hpp"

namespace shaker::campaign {

namespace {

std::string row(const CheckedPoint& c) {
    const Drive& d = c.point.asked.drive;
    const std::string travel = c.travel.fits()
                                   ? fmt::format("{:>7.1f} {:>6} {:>7.1f} {:>7.1f}", 1e3 * c.travel.way,
                                                 c.travel.passes, 1e3 * c.stage.begin, 1e3 * c.stage.end)
                                   : std::string{"does not fit"};
    return fmt::format("{:>5}  {:<12} {:>6.4g} {:>7.2f} {:>5.3g} {:>6.4g} {:>7.2f} {}{}\n", c.point.id,
                       c.point.series, d.gamma / paper_g, d.phi * 360 / two_pi, d.rho, d.frequency,
                       1e3 * c.travel.v_D, travel, d.biharmonic() ? "" : "  with overtones");
}

std::string duration(double s) {
    return s < 120 ? fmt::format("{:.1f} s", s) : fmt::format("{:.1f} min", s / 60);
}

nlohmann::ordered_json json_row(const CheckedPoint& c) {
    const Drive& d = c.point.asked.drive;
    nlohmann::ordered_json j{{"id", c.point.id}, {"series", c.point.series}, {"repeat", c.point.repeat}};
    j["partner"] = nullptr;
    if (c.point.partner != 0) j["partner"] = c.point.partner;
    for (std::size_t i = 0; i < drive_fields; ++i)
        j[std::string{point_fields.at(i).key}] = point_fields.at(i).in(c.point.asked);
    auto overtones = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < d.overtones.size(); ++i)
        if (d.overtones.at(i) != 0.0)
            overtones.push_back({i + 3, std::abs(d.overtones.at(i)), std::arg(d.overtones.at(i))});
    j["overtones"] = overtones;
    j["v_D_mps"] = c.travel.v_D;
    j["fits"] = c.travel.fits();
    j["why"] = c.travel.why;
    j["settling_periods"] = c.travel.settling;
    j["periods"] = c.travel.measured();
    j["passes"] = c.travel.passes;
    j["way_m"] = c.travel.way;
    j["begin_m"] = c.stage.begin;
    j["end_m"] = c.stage.end;
    j["returned_m"] = c.stage.returned;
    j["bench_s"] = c.stage.bench_s();
    return j;
}

}  // namespace

PlanCheck check_plan(const Plan& plan, std::vector<Point> points, const CheckSettings& settings,
                     const std::stop_token& stop) {
    PlanCheck check{
        .title = plan.title, .mu = plan.mu, .mu_target = plan.mu_target, .free_way = settings.way.length()};
    WalkPredictor predictor{plan.mu, settings.gravity, settings.timing.settle_at_most};
    double place = settings.start, frequency = 0;
    const ReturnDrives returns{points, settings.timing};
    check.points.reserve(points.size());
    for (Point& point : points) {
        if (stop.stop_requested()) throw InputError{"the check of the plan was stopped"};
        const Drive& drive = point.asked.drive;
        const Walk& walk = predictor.at(drive);
        const Walk& back = predictor.at(returns.at(walk.v_D < 0 ? 1 : -1, drive.frequency));
        const double free_way = check.free_way - kept_way(walk, back, settings.timing, drive.frequency) -
                                (settings.swing ? 2 * settings.swing(drive) : 0);
        const Travel t = travel(point.asked, walk, settings.timing, free_way);
        if (std::isnan(place)) place = best_start(t);
        const Stage stage = lead(t, settings.timing, free_way, place);
        if (drive.frequency != frequency) check.once_s += settings.once_s;
        frequency = drive.frequency;
        check.failing += t.fits() ? 0 : 1;
        check.settling_s += stage.settling_s;
        check.measuring_s += stage.measuring_s;
        check.returning_s += stage.returning_s;
        check.other_s += stage.other_s;
        check.points.push_back({std::move(point), t, stage});
    }
    check.bytes = settings.bytes_per_s * check.bench_s();
    return check;
}

std::string sums_text(const PlanCheck& check, std::string_view between) {
    return fmt::format(
        "{} points, {} fit{}bench time {}: measuring {}, settling {}, returning {}, start {}, other {}{}"
        "recording about {:.0f} MB",
        check.points.size(), check.points.size() - check.failing, between, duration(check.bench_s()),
        duration(check.measuring_s), duration(check.settling_s), duration(check.returning_s),
        duration(check.once_s), duration(check.other_s), between, check.bytes / 1e6);
}

std::string misfit_text(const CheckedPoint& point) {
    return fmt::format("point {} does not fit: {}", point.point.id, point.travel.why);
}

std::string check_text(const PlanCheck& check) {
    std::string text = fmt::format(
        "{}\npredicted with mu {:.4g}; free way {:.1f} mm\n\npoint  series       gamma     phi   rho frequ   "
        "  v_D     "
        "way passes    from      to\n                        g     deg            Hz    mm/s      mm         "
        "    mm     "
        " mm\n",
        check.title, check.mu, 1e3 * check.free_way);
    for (const CheckedPoint& c : check.points) text += row(c);
    for (const CheckedPoint& c : check.points)
        if (!c.travel.fits()) text += misfit_text(c) + "\n";
    if (check.mu_target > 0)
        text += fmt::format(
            "\nthe campaign ends when mu is known to {:.2g} %, and chooses the next point by "
            "what it adds to that\n",
            100 * check.mu_target);
    return text + "\n" + sums_text(check, "\n") + "\n";
}

std::string check_json(const PlanCheck& check) {
    nlohmann::ordered_json j{{"title", check.title},
                             {"mu", check.mu},
                             {"mu_target", check.mu_target},
                             {"free_way_m", check.free_way}};
    j["points"] = nlohmann::ordered_json::array();
    for (const CheckedPoint& c : check.points) j["points"].push_back(json_row(c));
    j["fit"] = check.points.size() - check.failing;
    j["bench_s"] = check.bench_s();
    j["measuring_s"] = check.measuring_s;
    j["settling_s"] = check.settling_s;
    j["returning_s"] = check.returning_s;
    j["start_s"] = check.once_s;
    j["other_s"] = check.other_s;
    j["bytes"] = check.bytes;
    return j.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

void require_within_limits(const Plan& plan, const std::vector<Point>& points, const Demands& demands) {
    for (const Point& p : points) {
        const std::vector<safety::Demand> needed = demands(p.asked.drive);
        try {
            safety::require_within(needed, p.asked.drive.gamma);
        } catch (const InputError& error) {
            const double in_g = p.asked.drive.gamma / paper_g;
            const auto series = std::ranges::find(plan.series, p.series, &Series::name);
            throw InputError{fmt::format("{}:{}: series \"{}\", gamma {:.4g}g: {}", plan.file,
                                         series->gamma_line, p.series, in_g, error.what())};
        }
    }
}

}  // namespace shaker::campaign
