#include "drivers/simulated/truth.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace shaker::simulated {

namespace {

double walker_at(const std::vector<PoseTruth>& poses, double t) {
    const auto after =
        std::ranges::lower_bound(poses, t, {}, [](const PoseTruth& p) { return seconds(p.time); });
    if (after == poses.end() || after == poses.begin()) return NAN;
    const auto before = std::prev(after);
    const double u = (t - seconds(before->time)) / (seconds(after->time) - seconds(before->time));
    return std::lerp(before->walker, after->walker, u);
}

}  // namespace

double drift_velocity(const std::vector<PoseTruth>& poses, double from_s, double to_s) {
    return (walker_at(poses, to_s) - walker_at(poses, from_s)) / (to_s - from_s);
}

}  // namespace shaker::simulated
