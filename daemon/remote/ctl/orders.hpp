#pragma once
// Commands that change the state of the bench.
#include "daemon/remote/ctl/table.hpp"

namespace shaker::ctl {

void set_drive(const Values& values);
void identify(const Values& values);
void start(const Values& values);
void stop(const Values& values);
void middle(const Values& values);
void reset_walker(const Values& values);
void give_mu(const Values& values);
/// Prints the regions of all targets, or moves one.
void targets(const Values& values);
/// "campaign WHAT [--plan NAME]": starts a plan, lists the plans, or passes a word to the campaign under way.
void campaign(const Values& values);
/// Sends no other request first; the daemon has 2 s to answer.
void abort(const Values& values);
void clear(const Values& values);
void remark(const Values& values);
void record(const Values& values);

}  // namespace shaker::ctl
