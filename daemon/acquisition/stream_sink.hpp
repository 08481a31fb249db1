#pragma once
// The receiver of a run's streams: a recording, or a test.
#include <optional>
#include <span>

#include "drivers/data.hpp"
#include "drivers/synthesiser.hpp"
#include "tracking/tracker.hpp"

namespace shaker::acquisition {

/// Receives each piece of data once, in the order in which the collector gathers it. All calls come from the
/// reduction thread and must not wait for a disk when the run is live.
class StreamSink {
public:
    StreamSink() = default;
    StreamSink(const StreamSink&) = delete;
    StreamSink& operator=(const StreamSink&) = delete;
    virtual ~StreamSink() = default;
    virtual void add(const PlayTime& played) = 0;
    virtual void add(const DriveChange& change) = 0;
    virtual void add(const AccelBlock& block) = 0;
    /// A frame and the positions of its targets. `time`: the final mid-exposure time of a frame that does not
    /// carry one; empty while it may still change.
    virtual void add(std::size_t camera, const Frame& frame, std::span<const tracking::Track> tracks,
                     const std::optional<MasterTime>& time) = 0;
};

}  // namespace shaker::acquisition
