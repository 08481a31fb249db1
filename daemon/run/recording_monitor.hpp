#pragma once
// Writes states and events of a run to its recording, and stops the run when the recording fails.

#include "daemon/recording/recorder.hpp"
#include "daemon/run/sequence.hpp"

namespace shaker::run {

class RecordingMonitor {
public:
    /// The recording must outlive this object.
    explicit RecordingMonitor(recording::Recorder& recording) : recording_{recording} {}
    /// The recording starts in the middle of a run: it has no events and measurements of before.
    void omit_before(const Sequence& sequence);
    /// Call it after each step of the sequence. Stops the drive softly when the recording has failed or when
    /// its backlog is almost so large that samples would be lost.
    void update(Sequence& sequence, const acquisition::Streams& streams, acquisition::Channels& channels);

private:
    recording::Recorder& recording_;
    RunState state_ = RunState::init;
    bool begun_ = false, stopped_ = false;
    std::size_t notes_ = 0, finished_ = 0;
    int omitted_ = 0;  // measurements
    recording::MeasuredPart measured_;
    double well_s_ = 0;  // master time of the last update without trouble
};

}  // namespace shaker::run
