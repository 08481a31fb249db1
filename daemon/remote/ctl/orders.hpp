#pragma once
// The commands that change what the bench does.
#include "daemon/remote/ctl/table.hpp"

namespace shaker::ctl {

void set_drive(const Given& given);
void identify(const Given& given);
void start(const Given& given);
void stop(const Given& given);
/// Nothing else is asked of the daemon before, and it is given 2 s.
void abort(const Given& given);
void clear(const Given& given);
void remark(const Given& given);
void record(const Given& given);

}  // namespace shaker::ctl
