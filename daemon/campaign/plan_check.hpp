#pragma once
// The check of a plan before anything moves: points in their order, predicted travel, bench time, bytes.
#include <cmath>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/campaign/plan.hpp"
#include "daemon/campaign/travel.hpp"
#include "daemon/safety/preflight.hpp"

namespace shaker::campaign {

struct CheckSettings {
    FreeWay way{};
    Timing timing{};
    double start = NAN;        // place of the walker, m from the middle of the view; NaN: best_start()
    double gravity = paper_g;  // m/s^2
    /// Peak of the base's displacement at a drive, m, by which the walker swings; empty: not known, 0.
    std::function<double(const Drive&)> swing{};
    double once_s = 8;            // self-test, identified response, soft start; again for another frequency
    double bytes_per_s = 0.35e6;  // of the recording
};

struct CheckedPoint {
    Point point{};
    Travel travel{};
    Stage stage{};
};

struct PlanCheck {
    std::string title;
    double mu = 0, mu_target = 0;  // of the plan
    double free_way = 0;           // m
    std::vector<CheckedPoint> points{};
    std::size_t failing = 0;  // points that do not fit
    double once_s = 0;        // and the sums of the points, s:
    double settling_s = 0, measuring_s = 0, returning_s = 0, other_s = 0;
    double bytes = 0;
    [[nodiscard]] double bench_s() const noexcept {
        return once_s + settling_s + measuring_s + returning_s + other_s;
    }
};

/// points: of the plan. InputError when `stop` asks for the end.
PlanCheck check_plan(const Plan& plan, std::vector<Point> points, const CheckSettings& settings,
                     const std::stop_token& stop = {});

/// Number of points, bench time and size of the recording, with `between` between the three.
std::string sums_text(const PlanCheck& check, std::string_view between);
/// "point 3 does not fit: ...".
std::string misfit_text(const CheckedPoint& point);
/// A table with one row a point, the points that do not fit with reasons, and the sums.
std::string check_text(const PlanCheck& check);
/// One JSON object, SI units in the key names.
std::string check_json(const PlanCheck& check);

using Demands = std::function<std::vector<safety::Demand>(const Drive&)>;
/// Throws InputError with file and line of gamma for the first set-point beyond a limit, and the largest
/// gamma that all limits allow there.
void require_within_limits(const Plan& plan, const std::vector<Point>& points, const Demands& demands);

}  // namespace shaker::campaign
