#pragma once
// The events of a campaign in words, for the terminal and the log.
#include <string>
#include <vector>

#include "daemon/campaign/engine.hpp"

namespace shaker::campaign {

/// Series and drive of a point: "pair 20 Hz gamma 9.8 m/s^2 rho 0.5 phi 35.0 deg".
std::string place(const Point& point);
/// The event as one sentence; empty for one that a person need not read. points: of the engine, in their
/// order.
std::string text(const Event& event, const Engine& engine, const std::vector<Point>& points);

}  // namespace shaker::campaign
