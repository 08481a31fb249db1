#pragma once
// Finds and reads parts of a recording that is being written, so that its data need not stay in memory.
#include <cstdint>
#include <limits>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// An index in memory of the accelerometer blocks and tracks in the file: one entry per slice of about a
/// second, which is 0.1 kB/s. One thread.
class RecordedParts {
public:
    explicit RecordedParts(const std::vector<View>& views);
    /// Pieces in the order in which they are written to the file.
    void add(const PlayTime& played) { last_ = played; }
    void add(const AccelBlock& block);
    /// Times of a frame's tracks, one per target of the camera.
    void add(std::size_t camera, std::span<const double> times);

    /// Reads all data that the reduction of `part` uses. streams: of the whole run, with settled times; its
    /// data lists are not used. DeviceError when the disk fails.
    [[nodiscard]] acquisition::Streams read(const MeasuredPart& part, double frequency_hz,
                                            const acquisition::Streams& streams,
                                            recorded::RecordingWriter& file) const;

private:
    struct BlockSlice {
        std::int64_t least_tick;
        std::size_t first_sample;
    };
    struct TrackSlice {
        double least_s = std::numeric_limits<double>::infinity();
        bool unknown = false;  // it has a frame without a time
    };
    struct Tracks {
        std::size_t camera;
        Target target;
        std::vector<TrackSlice> slices{};
        std::size_t rows = 0;
    };

    [[nodiscard]] std::vector<AccelBlock> blocks(const acquisition::ReadPart& part,
                                                 const calibration::Timebase& timebase,
                                                 recorded::RecordingWriter& file) const;
    [[nodiscard]] std::vector<tracking::Track> tracks(const Tracks& of, const acquisition::ReadPart& part,
                                                      recorded::RecordingWriter& file) const;

    std::vector<View> views_;
    std::vector<BlockSlice> blocks_;
    std::size_t block_rows_ = 0, samples_ = 0;
    std::vector<Tracks> tracks_;            // of all targets of all cameras
    std::vector<std::size_t> first_track_;  // of each camera, in tracks_
    std::optional<PlayTime> last_;
};

}  // namespace shaker::recording
