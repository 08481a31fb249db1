#pragma once
// Messages of the daemon as text. A missing value is left out or shown as "-".
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace shaker::ctl {

/// The values of "state" in the daemon's messages.
inline constexpr std::array<std::string_view, 11> state_words{
    "starting", "idle",    "armed",    "identifying", "checking", "ramping",
    "settling", "running", "stopping", "tripped",     "finishing"};

std::string state_of(const nlohmann::json& state);
/// Cause of the trip; empty without a trip.
std::string trip_of(const nlohmann::json& state);
/// True if the state contains a measurement.
bool has_result(const nlohmann::json& state);

/// "v_D 14.500 +- 0.030 mm/s", or "v_D -".
std::string drift_text(const nlohmann::json& state);
/// The whole state: one line per item, name and value.
std::string state_text(const nlohmann::json& state);
/// One line without a line end.
std::string state_line(const nlohmann::json& state);
std::string event_text(const nlohmann::json& event);

}  // namespace shaker::ctl
