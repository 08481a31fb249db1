#pragma once
// Signals that end a command which drives the shaker. Without a handler they would end the process, and the
// drive with a step.
#include "daemon/run/runner.hpp"

namespace shaker::run {

/// During its lifetime SIGINT, SIGTERM and SIGHUP ask the runner to stop, or are only remembered for
/// rethrow(). They interrupt a wait for the operator's input. One object at a time.
class StopSignals {
public:
    explicit StopSignals(Runner& runner);
    StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;
    ~StopSignals();
    /// Throws Interrupted if a signal came.
    static void rethrow();
};

}  // namespace shaker::run
