#pragma once
// Writes a recording during a run. The reduction thread adds data, a separate thread writes them. The file
// gets its name when it is complete; until then it is FILE.part, which is locked while it is written.
#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/journal.hpp"
#include "daemon/recording/recorded_parts.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/stream_tables.hpp"
#include "daemon/reduction/reduction.hpp"
#include "drivers/handover.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::pictures {
class PictureStore;
}  // namespace shaker::pictures

namespace shaker::recording {

/// Treatment of FILE.part when a recording is never finished. The data of a live run exist nowhere else, so
/// they are kept.
enum class Unfinished { keep, discard };

struct RecorderSettings {
    Unfinished unfinished = Unfinished::keep;
    /// Live run: a separate thread calls step(), flushed data are synchronised with the disk each half
    /// second, and up to 2 s of pictures wait in memory. Otherwise add() writes the data directly.
    bool live = false;
    /// Times of tracks are final when they are added. Measurements are then reduced from the file, so the
    /// streams of the run need not stay in memory.
    bool final_times = false;
    /// Called after each step of finish(): a measurement, a picture of a tail, the files of a camera.
    std::function<void()> progress = [] {};
    double started_s = 0;  // master time of the date in the header
    /// Free space on the disk below which nothing more is recorded.
    std::uint64_t least_free_bytes = std::uint64_t{1} << 30U;
};

/// With an empty file name all functions do nothing.
/// Thread safety: the reduction thread calls add(), which never waits for the disk in a live run. The
/// recorder's thread calls step(). All other functions without a remark are for one thread, after the other
/// has ended.
class Recorder final : public acquisition::StreamSink {
public:
    /// InputError when the disk has less than least_free_bytes besides the first pictures, DeviceError when
    /// the file cannot be created.
    Recorder(const std::filesystem::path& file, const recorded::RecordingHeader& header,
             const RecorderSettings& settings);
    ~Recorder() override;
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;
    [[nodiscard]] bool on() const noexcept { return writer_ != nullptr; }
    /// From now on an unfinished FILE.part is kept.
    void keep_unfinished() noexcept { settings_.unfinished = Unfinished::keep; }

    void add(const PlayTime& played) override { push(played); }
    void add(const DriveChange& change) override { push(change); }
    void add(const AccelBlock& block) override { push(block); }
    void add(const LogEntry& entry) { push(entry); }
    /// Adds a measurement that starts.
    void add(const MeasuredPart& part) { push(part); }
    /// Adds a finished measurement; the recording will have its results. The recorder sets `time`.
    void add(const FinishedMeasurement& finished);
    /// Adds a frame with the tracks of its targets. When too many pictures wait, this one is dropped and
    /// counted. mid_exposure: final value, used if the frame itself has none.
    void add(std::size_t camera, const Frame& frame, std::span<const tracking::Track> tracks,
             const std::optional<MasterTime>& mid_exposure) override;

    /// Writes the waiting data; false when no data waited. After a failure data are counted, not written.
    bool step();
    /// Reason of a failure that ended the recording; empty without a failure. Any thread.
    [[nodiscard]] std::optional<std::string> failure() const;
    /// Filled share of the queue, 0 to 1. Any thread.
    [[nodiscard]] double backlog() const noexcept;
    /// Pieces of data lost because the queue was full, or after a failure.
    [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

    /// The file, for all other tables; writes the waiting data first. DeviceError after a failure.
    [[nodiscard]] recorded::RecordingWriter& writer();
    /// Adds a picture of the last seconds before a trip, in a recording that does not keep whole pictures.
    void tail(std::size_t camera, const Frame& frame);
    /// With final times: the data that the reduction of `part` uses, from the file. Empty otherwise:
    /// `streams` has them. streams: of the run, with settled times. DeviceError after a failure.
    [[nodiscard]] std::optional<acquisition::Streams> around(const MeasuredPart& part,
                                                             const acquisition::Streams& streams);
    /// Writes final times of tracks, results of every finished measurement, clocks, gaps and counts, and
    /// gives the file its name. DeviceError when a part could not be written, or when another file has got
    /// the name; then FILE.part stays.
    void finish(const acquisition::Streams& streams);
    /// As above, with results and the part of master time from which they were made, s.
    void finish(const acquisition::Streams& streams, const reduction::Reduction& reduction, double from_s,
                double to_s);

private:
    struct Entry {
        std::size_t camera;
        Frame frame;  // without pixels
        FramePtr picture;
        bool wanted = false;       // the recording keeps the picture of this frame
        std::vector<double> rows;  // track rows of all targets, one after the other
    };
    using Piece =
        std::variant<PlayTime, DriveChange, AccelBlock, LogEntry, MeasuredPart, FinishedMeasurement, Entry>;
    class Pictures;
    /// A reduction that is already available, and its part, which may be that of a finished measurement.
    struct Known {
        MeasuredPart part;
        const reduction::Reduction* reduction = nullptr;
    };

    [[nodiscard]] bool wants(std::size_t camera, const Frame& frame);
    void push(Piece piece);
    void write(const Piece& piece);
    void write(const Entry& entry);
    void advance(double s);
    void flush();
    void fail(const std::string& why) noexcept;
    void write_journal(const LogEntry& entry) noexcept;
    void complete(const acquisition::Streams& streams, const Known& known);
    [[nodiscard]] MeasuredResult result_of(const FinishedMeasurement& finished,
                                           const acquisition::Streams& streams, const Known& known);
    void give_name();

    std::filesystem::path file_, part_;
    RecorderSettings settings_;
    recorded::RecordingHeader header_;
    std::unique_ptr<recorded::RecordingWriter> writer_;
    std::unique_ptr<Journal> journal_;
    std::vector<std::unique_ptr<pictures::PictureStore>> stores_, tails_;
    std::vector<std::unique_ptr<Pictures>> waiting_;
    std::vector<std::optional<CameraTick>> first_;  // of each camera, first frame; the reduction thread's
    std::vector<std::vector<std::size_t>> tables_;  // track tables by camera and target
    bool tracks_written_ = false;                   // together with the frames
    std::vector<PictureCounts> counts_;
    std::vector<FinishedMeasurement> finished_;
    std::optional<RecordedParts> parts_;  // with final times
    GapFinder gaps_;
    std::optional<Ring<std::shared_ptr<const Piece>>> ring_;
    std::atomic<std::uint64_t> pushed_{0}, popped_{0}, lost_{0};
    double now_s_ = 0, flushed_s_ = 0;
    std::string state_;         // last recorded state of the run
    mutable std::mutex mutex_;  // guards failure_
    std::optional<std::string> failure_;
    std::atomic<bool> failed_{false};
    bool closed_ = false;  // nothing can be added to the file
};

/// InputError naming the file when FILE exists, or FILE.part of a crash or of a recording that another
/// process is writing: no recording is overwritten.
void require_new(const std::filesystem::path& file);

}  // namespace shaker::recording
