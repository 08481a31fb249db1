#pragma once
// The commands that only look, and what others need to look on.
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "daemon/remote/ctl/table.hpp"

namespace shaker::ctl {

void status(const Given& given);
void watch(const Given& given);
void fetch(const Given& given);
void wait_for(const Given& given);

/// The first state that is `wanted`; none where there was none until then. Refused, with why, when the drive
/// is stopped by a limit or an abort before that.
std::optional<nlohmann::json> state_when(const Link& link, Clock::time_point until,
                                         const std::function<bool(const nlohmann::json&)>& wanted);

}  // namespace shaker::ctl
