#include "daemon/campaign/way_back.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace shaker::campaign {

namespace {
constexpr double patience = 3;    // by the expected time of a return
constexpr double patience_s = 5;  // in addition
constexpr double learned = 0.5;   // share of the newest return
constexpr double most_periods = 8;
constexpr double kept_periods = 1;  // of way on the other side
}  // namespace

void WayBack::begin(double now_s, double x_m, std::size_t ahead, double way, double target, double step,
                    double period_s) {
    x_m_ = x_m, way_ = way, target_ = target, step_ = step;
    ahead_ = ahead;
    left_ = false;
    from_s_ = now_s;
    until_s_ = now_s + patience * std::max(0.0, target - way) / step * period_s + patience_s;
}

bool WayBack::arrives(const std::array<double, 2>& ways) const noexcept {
    return ways.at(ahead_) + goes_on_ * step_ >= target_ ||
           ways.at(1 - ahead_) <= std::max(goes_on_, kept_periods) * step_;
}

void WayBack::leave(double now_s, double way) noexcept {
    for_s_ = now_s - from_s_;
    left_at_ = farthest_ = way;
    left_ = true;
}

void WayBack::follow(double way) noexcept { farthest_ = std::max(farthest_, way); }

WayBack::Done WayBack::end() {
    left_ = false;
    goes_on_ = std::min(std::lerp(goes_on_, (farthest_ - left_at_) / step_, learned), most_periods);
    const double forward = ahead_ == 0 ? -1 : 1;
    return {x_m_, x_m_ - forward * (target_ - way_), x_m_ - forward * (farthest_ - way_), for_s_};
}

}  // namespace shaker::campaign
