#include "daemon/run/recording_monitor.hpp"

#include "drivers/time.hpp"

namespace shaker::run {

namespace {
constexpr double most_backlog = 0.8;  // share of the recorder's queue
}

void RecordingMonitor::update(Sequence& sequence, const acquisition::Streams& streams,
                              acquisition::Channels& channels) {
    if (!recording_.on()) return;
    const double now_s =
        streams.played.empty() ? 0 : counted_s(streams.played.back().tick, streams.dac_rate_hz);
    if (!begun_ || sequence.state() != state_) {
        begun_ = true;
        state_ = sequence.state();
        recording_.add(recording::LogEntry{now_s, name(state_), {}});
    }
    if (sequence.to_s() > sequence.from_s() &&
        (sequence.from_s() != measured_.from_s || sequence.to_s() != measured_.to_s)) {
        measured_ = {sequence.from_s(), sequence.to_s()};
        recording_.add(measured_);
    }
    for (; finished_ < sequence.measured().size(); ++finished_) {
        recording::FinishedMeasurement finished = sequence.measured()[finished_];
        finished.number -= omitted_;
        recording_.add(finished);
    }
    for (; notes_ < sequence.notes().size(); ++notes_)
        recording_.add(recording::LogEntry{now_s, name(state_), sequence.notes()[notes_]});
    if (!recording_.failure() && recording_.backlog() < most_backlog) {
        well_s_ = now_s;
        return;
    }
    if (stopped_ || sequence.trip()) return;
    stopped_ = true;
    sequence.stop(channels, {.cause = safety::Cause::recorder, .value = now_s - well_s_});
}

void RecordingMonitor::omit_before(const Sequence& sequence) {
    measured_ = {sequence.from_s(), sequence.to_s()};
    finished_ = sequence.measured().size();
    omitted_ = static_cast<int>(finished_);
    notes_ = sequence.notes().size();
}

}  // namespace shaker::run
