#pragma once
// The commands of shakerctl as one table: parsing, help and manual page are made from it.
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "daemon/manual/command.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/orders/row.hpp"
#include "daemon/remote/ctl/link.hpp"

namespace shaker::ctl {

using manual::Values;

const manual::Program& program();

/// The daemon given by --at or SHAKERD_URL, with the token of --token-file or SHAKERD_TOKEN.
Link link_of(const Values& values);

/// Gives an order with the values that were typed.
void give_order(const orders::Row& row, const Values& values);

// Commands that change the state of the bench and do more than that (orders.cpp).
void set_drive(const Values& values);
void start(const Values& values);
void stop(const Values& values);
void middle(const Values& values);
/// Prints the regions of all targets, or moves one.
void targets(const Values& values);
/// "campaign WHAT [--plan NAME]": starts a plan, lists the plans, or passes a word to the campaign under way.
void campaign(const Values& values);
/// Measures a scan of one parameter.
void scan(const Values& values);
/// Sends no other request first; the daemon has 2 s to answer.
void abort(const Values& values);
void clear(const Values& values);

// Commands that only read the state of the bench (queries.cpp), and a helper for the others.
void status(const Values& values);
void watch(const Values& values);
void fetch(const Values& values);
void wait_for(const Values& values);

/// Waits for the first state for which `wanted` holds. Empty after the time limit. Refused, with the cause,
/// if a limit or an abort stops the drive first.
std::optional<nlohmann::json> state_when(const Link& link, Clock::time_point until,
                                         const std::function<bool(const nlohmann::json&)>& wanted);

}  // namespace shaker::ctl
