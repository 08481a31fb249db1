#pragma once
// Between a run and its recording: states and events go into it, its troubles come back and end the run.
#include <string>

#include "daemon/recording/recorder.hpp"
#include "daemon/run/sequence.hpp"

namespace shaker::run {

class RecordingMonitor {
public:
    /// The recording outlives this.
    explicit RecordingMonitor(recording::Recorder& recording) : recording_{recording} {}
    /// After each step of the director. A recording that failed, or is nearly so far behind that samples
    /// would be lost, stops the drive softly: what is not recorded need not be driven.
    void look(Sequence& sequence, const acquisition::Streams& streams, acquisition::Channels& channels);

private:
    recording::Recorder& recording_;
    RunState state_ = RunState::init;
    bool begun_ = false, stopped_ = false;
    std::size_t notes_ = 0, finished_ = 0;
    recording::MeasuredPart measured_;
    double well_s_ = 0;  // master time when all was well last
};

/// A new one each time (UUID).
std::string new_identifier();

}  // namespace shaker::run
