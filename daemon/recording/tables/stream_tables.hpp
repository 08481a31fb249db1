#pragma once
// Tables about the raw streams: clocks, gaps, numbers of pictures.
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/columns.hpp"

namespace shaker::recording {

/// One clock. stream: 0 the DAC relative to the host, 1 the accelerometer, 2 and above the cameras.
struct ClockRow {
    std::size_t stream = 0;
    double ppm = 0, ppm_sigma = 0;  // rate relative to nominal, minus 1
    double delay_s = 0;             // mean delay of the stamps
    std::size_t stamps = 0;
};
extern const Table<ClockRow> clock_columns;
/// The clocks determined from all stamps of a run; no row for a stream without stamps.
std::vector<ClockRow> clocks_of(const acquisition::Streams& streams);

/// Missing samples or frames. stream: as in ClockRow.
struct Gap {
    std::size_t stream = 0;
    std::int64_t first = 0, count = 0;
};
extern const Table<Gap> gap_columns;
/// Finds missing data in pieces that are added in the order of each stream.
class GapFinder {
public:
    void add(const PlayTime& played);
    void add(const AccelBlock& block);
    void add(std::size_t camera, CameraTick frame);
    /// All gaps until now, ordered by stream.
    [[nodiscard]] std::vector<Gap> gaps() const;

private:
    struct Stream {
        std::optional<std::int64_t> next;  // expected number; empty before the first piece
        std::vector<Gap> gaps;
    };
    void expect(std::size_t stream, std::int64_t first, std::int64_t next);
    std::vector<Stream> streams_{2};
};
std::vector<Gap> gaps_of(const acquisition::Streams& streams);

/// Numbers of a camera's pictures: produced = stored + dropped + not_kept (excluded by the settings).
struct PictureCounts {
    std::uint64_t produced = 0, stored = 0, dropped = 0, not_kept = 0;
};
extern const Table<PictureCounts> picture_columns;
/// "pictures/top".
std::string pictures_path(const std::string& camera);

/// Writes clocks and gaps.
void write_streams(recorded::RecordingWriter& file, const acquisition::Streams& streams,
                   const std::vector<Gap>& gaps);
void write(recorded::RecordingWriter& file, const std::string& camera, const PictureCounts& counts);

}  // namespace shaker::recording
