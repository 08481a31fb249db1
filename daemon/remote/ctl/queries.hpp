#pragma once
// Commands that only read the state of the bench, and helpers for the others.
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "daemon/remote/ctl/table.hpp"

namespace shaker::ctl {

void status(const Values& values);
void watch(const Values& values);
void fetch(const Values& values);
void wait_for(const Values& values);

/// Waits for the first state for which `wanted` holds. Empty after the time limit. Refused, with the cause,
/// if a limit or an abort stops the drive first.
std::optional<nlohmann::json> state_when(const Link& link, Clock::time_point until,
                                         const std::function<bool(const nlohmann::json&)>& wanted);

}  // namespace shaker::ctl
