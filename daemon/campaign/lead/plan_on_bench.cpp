#include "daemon/campaign/lead/plan_on_bench.hpp"

#include <algorithm>
#include <map>

#include "daemon/run/run_setup.hpp"

namespace shaker::campaign {

namespace {

double walker_m(const View& view) {
    double mm = 0;
    for (const Target& t : view.targets)
        if (t.name == "walker") mm = std::max(t.diameter_mm, t.width_mm);
    return 1e-3 * mm;
}

}  // namespace

CheckSettings check_settings(const Plan& plan, const std::vector<Point>& points, const bench::Bench& bench) {
    std::map<std::vector<double>, double> swings;  // m, by drive
    for (const Point& p : points) {
        const Drive& drive = p.asked.drive;
        const auto demands = run::run_demands(bench, drive, bench.limits);
        swings.try_emplace(
            numbers_of(drive),
            1e-3 * std::ranges::find(demands, "displacement", &safety::Demand::quantity)->value);
    }
    return {.way = {.walker = walker_m(bench.rig.cameras.front()->view()),
                    .edge = 1e-3 * bench.limits.edge_mm,
                    .margin = 1e-3 * plan.edge_margin_mm},
            .gravity = bench.gravity,
            .swing = [swings](const Drive& drive) { return swings.at(numbers_of(drive)); }};
}

}  // namespace shaker::campaign
