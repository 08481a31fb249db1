#pragma once
// The daemon's messages in words. Whatever is missing in one is left out or shown as "-".
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace shaker::ctl {

/// What "state" of a session may be.
inline constexpr std::array state_words{"starting", "idle",    "armed",    "identifying", "ramping",
                                        "settling", "running", "stopping", "tripped"};

std::string state_of(const nlohmann::json& state);
/// Why the drive was stopped; empty where it was not.
std::string trip_of(const nlohmann::json& state);
/// A measurement is there.
bool has_result(const nlohmann::json& state);

/// "v_D 14.500 +- 0.030 mm/s", or "v_D -".
std::string drift_text(const nlohmann::json& state);
/// All of it, lines of a name and what is to say of it.
std::string state_text(const nlohmann::json& state);
/// One line without its end.
std::string state_line(const nlohmann::json& state);
std::string event_text(const nlohmann::json& event);

}  // namespace shaker::ctl
