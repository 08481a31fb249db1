#pragma once
// Between a run and its recording: states and events go into it, its troubles come back and end the run.
#include <string>

#include "daemon/director.hpp"
#include "daemon/recording.hpp"

namespace shaker {

class RecordingWatch {
public:
    /// The recording outlives this.
    explicit RecordingWatch(Recording& recording) : recording_{recording} {}
    /// After each step of the director. A recording that failed, or is nearly so far behind that samples
    /// would be lost, stops the drive softly: what is not recorded need not be driven.
    void look(Director& director, const Take& take, Lanes& lanes);

private:
    Recording& recording_;
    RunState state_ = RunState::init;
    bool begun_ = false, stopped_ = false;
    std::size_t notes_ = 0;
    MeasuredPart measured_;
    double well_s_ = 0;  // master time when all was well last
};

/// A new one each time (UUID).
std::string new_identifier();

}  // namespace shaker
