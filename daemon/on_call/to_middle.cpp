#include "daemon/on_call/to_middle.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "drivers/errors.hpp"

namespace shaker::on_call {

namespace {

constexpr std::array gammas{paper_g, 1.5 * paper_g, 2 * paper_g, 3 * paper_g};  // m/s^2
constexpr double in_the_middle_m = 1e-3;
constexpr double wrong_way_m = 1e-3;           // from its start
constexpr double identification_way_m = 0.01;  // that a walker may walk while the response is identified
constexpr double near_share = 0.4;             // of the whole way, in a narrow view

}  // namespace

ToMiddle::Way ToMiddle::way(const run::WalkerMonitor& walker, double edge_mm, double frequency,
                            const std::vector<reduction::DrivenPoint>& points,
                            const calibration::Estimate& mu, double g,
                            const RequirePossible& require_possible) {
    const std::array<double, 2> ways = walker.ways_m(edge_mm);
    if (!std::isfinite(ways[0]))
        throw InputError{
            "the walker is in no picture, so that it cannot be brought to the middle; check the light, the "
            "cameras and their target \"walker\", or move it by hand"};
    const double off_m = (ways[0] - ways[1]) / 2;
    if (std::abs(off_m) < in_the_middle_m)
        throw InputError{
            fmt::format("the walker is {:.1f} mm from the middle already", 1e3 * std::abs(off_m))};
    const int direction = off_m < 0 ? 1 : -1;
    const double near_m = std::min(identification_way_m, near_share * (ways[0] + ways[1]));
    const bool near = std::min(ways[0], ways[1]) < near_m;
    std::string weak;
    for (const double gamma : gammas) {
        Drive drive;
        drive.frequency = frequency;
        drive.gamma = gamma;
        drive.phi = direction > 0 ? 0 : std::numbers::pi;
        try {
            require_possible(drive);
        } catch (const InputError& e) {
            if (weak.empty()) throw;
            break;
        }
        auto walk = run::predict_walk(drive, points, mu, g);
        if (!walk) walk = run::walk_at_usual_friction(drive, g);
        if (walk && run::leads_towards(*walk, direction))
            return {drive, *walk, {.plan = {.periods = 0}, .identifies = !near}};
        weak = walk ? run::text(*walk) : "its direction cannot be predicted";
    }
    throw InputError{fmt::format(
        "no drive within the limits leads the walker to the middle for certain: {}; correct mu, or "
        "move it by hand",
        weak)};
}

bool ToMiddle::over(double now_s, const run::WalkerMonitor& walker, double edge_mm) {
    const std::array<double, 2> ways = walker.ways_m(edge_mm);
    if (state_ == State::stops || !std::isfinite(ways[0])) return false;
    const std::size_t ahead = way_.walk.v_D.value > 0 ? 0 : 1;  // the side whose way grows
    const double way_m = ways.at(ahead);
    if (state_ == State::starts) {
        state_ = State::goes;
        least_way_m_ = way_m - wrong_way_m;
        const double f = way_.drive.frequency;
        way_back_.begin(now_s, walker.x_m().value_or(NAN), ahead, way_m, (ways[0] + ways[1]) / 2,
                        std::abs(way_.walk.v_D.value) / f, 1 / f);
    }
    const bool arrives = way_back_.arrives(ways);
    if (way_m < least_way_m_)
        trouble_ = "it went away from the middle: level the base and check the camera's direction";
    else if (!arrives && way_back_.late(now_s))
        trouble_ =
            "the walker does not move to the middle: mu is larger than expected, or something holds it";
    if (!arrives && trouble_.empty()) return false;
    state_ = State::stops;
    if (trouble_.empty()) way_back_.leave(now_s, way_m);
    return true;
}

std::string ToMiddle::end(const run::WalkerMonitor& walker, double edge_mm) {
    const std::array<double, 2> ways = walker.ways_m(edge_mm);
    state_ = State::none;
    if (way_back_.left() && std::isfinite(ways[0])) {
        way_back_.follow(ways.at(way_back_.ahead()));
        way_back_.end();
    }
    way_back_.abandon();
    std::string where = "the walker is in no picture";
    if (std::isfinite(ways[0]))
        where = fmt::format("the walker is {:.1f} mm from the middle", 1e3 * std::abs(ways[0] - ways[1]) / 2);
    return trouble_.empty() ? where : where + "; " + trouble_;
}

}  // namespace shaker::on_call
