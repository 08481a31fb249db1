#pragma once
// The commands of shakerctl as one table: parsing, help and manual page are made from it.
#include "daemon/manual/command.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/remote/ctl/link.hpp"

namespace shaker::ctl {

using manual::Values;

const manual::Program& program();

/// The daemon given by --at or SHAKERD_URL, with the token of --token-file or SHAKERD_TOKEN.
Link link_of(const Values& values);

}  // namespace shaker::ctl
