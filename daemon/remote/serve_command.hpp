#pragma once
// shakerd serve: a bench on call, with its remote side.
#include "daemon/commands.hpp"

namespace shaker {

/// Runs until SIGTERM or SIGINT, then brings the drive down softly and finishes what is recorded.
void serve(const ServeOptions& options);

}  // namespace shaker
