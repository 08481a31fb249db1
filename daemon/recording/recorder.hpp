#pragma once
// A recording while it is made: fed by the reduction, written by a loop of its own, under its name only when
// it is complete.
#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "daemon/acquisition/stream_sink.hpp"
#include "daemon/recording/journal.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/stream_tables.hpp"
#include "daemon/reduction/reduction.hpp"
#include "drivers/handover.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::pictures {
class PictureStore;
}  // namespace shaker::pictures

namespace shaker::recording {

/// What becomes of FILE.part when a recording is never finished: a live run's data exist nowhere else.
enum class Unfinished { keep, discard };

struct RecorderSettings {
    Unfinished unfinished = Unfinished::keep;
    /// Of a live run: a thread of its own calls step(), what was flushed is seen onto the disk each half
    /// second, and up to 2 s of pictures wait in memory. Otherwise add() writes each piece of data itself.
    bool live = false;
    double started_s = 0;  // master time of the header's date: a daemon's master time began long before
    std::uint64_t least_free_bytes = std::uint64_t{1} << 30U;  // on the disk; then nothing more is recorded
};

/// Without a file name everything here does nothing. add() is for the reduction's thread and, live, never
/// waits for the disk; step() is for the recorder's thread; what else there is for either when the other has
/// ended.
class Recorder final : public acquisition::StreamSink {
public:
    /// InputError when the disk has less room than it must have for a beginning, DeviceError when the file
    /// cannot be made.
    Recorder(const std::filesystem::path& file, const recorded::RecordingHeader& header,
             const RecorderSettings& settings);
    ~Recorder() override;
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;
    [[nodiscard]] bool on() const noexcept { return writer_ != nullptr; }

    void add(const PlayTime& played) override { push(played); }
    void add(const DriveChange& change) override { push(change); }
    void add(const AccelBlock& block) override { push(block); }
    void add(const LogEntry& entry) { push(entry); }
    /// What is being measured from now on.
    void add(const MeasuredPart& part) { push(part); }
    /// A measurement is finished: the recording will have its results. The time is the recorder's.
    void add(const FinishedMeasurement& finished);
    /// A frame and where its targets are. Its picture is left out and counted when too many wait. told: of
    /// mid-exposure, final, where the frame does not tell it.
    void add(std::size_t camera, const Frame& frame, std::span<const tracking::Track> tracks,
             const std::optional<MasterTime>& told) override;

    /// Writes what waits; false when nothing did. After a failure what comes is counted and not written.
    bool step();
    /// Why nothing is recorded any more; any thread.
    [[nodiscard]] std::optional<std::string> failure() const;
    /// What waits to be written, as a share of what may wait; any thread.
    [[nodiscard]] double backlog() const noexcept;
    /// Pieces of data that found no room or came after a failure.
    [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

    /// Where everything else of the recording goes, once all that waits has been written.
    [[nodiscard]] recorded::RecordingWriter& writer();
    /// One picture of the last seconds, where a recording does not keep whole ones.
    void tail(std::size_t camera, const Frame& frame);
    /// The measurements that were added.
    [[nodiscard]] const std::vector<FinishedMeasurement>& finished() const noexcept { return finished_; }
    /// Adds tracks' final times, the results of every finished measurement, clocks, gaps and counts, and
    /// gives the file its name. DeviceError when something of it could not be written; then FILE.part stays.
    void finish(const acquisition::Streams& streams);
    /// Likewise, with results and the part of master time they were made from.
    void finish(const acquisition::Streams& streams, const reduction::Reduction& reduction, double from_s,
                double to_s);

private:
    struct Entry {
        std::size_t camera;
        Frame frame;  // without pixels
        FramePtr picture;
        std::vector<double> rows;  // of all targets behind each other
    };
    using Piece =
        std::variant<PlayTime, DriveChange, AccelBlock, LogEntry, MeasuredPart, FinishedMeasurement, Entry>;
    class Pictures;
    /// A reduction that was made already, of a part that may be a finished measurement.
    struct Known {
        MeasuredPart part;
        const reduction::Reduction* reduction = nullptr;
    };

    void push(const Piece& piece);
    void write(const Piece& piece);
    void write(const Entry& entry);
    void tell_time(double s);
    void flush();
    void fail(const std::string& why) noexcept;
    void tell_journal(const LogEntry& entry) noexcept;
    void complete(const acquisition::Streams& streams, const Known& known);

    std::filesystem::path file_, part_;
    RecorderSettings settings_;
    recorded::RecordingHeader header_;
    std::unique_ptr<recorded::RecordingWriter> writer_;
    std::unique_ptr<Journal> journal_;
    std::vector<std::unique_ptr<pictures::PictureStore>> stores_, tails_;
    std::vector<std::unique_ptr<Pictures>> waiting_;
    std::vector<std::vector<std::size_t>> tables_;  // of tracks: a camera, a target
    bool tracks_written_ = false;                   // with the frames, as they came
    std::vector<PictureCounts> counts_;
    std::vector<FinishedMeasurement> finished_;
    std::optional<Ring<Piece>> ring_;
    std::atomic<std::uint64_t> pushed_{0}, popped_{0}, lost_{0};
    double now_s_ = 0, flushed_s_ = 0;
    std::string state_;         // of the run, when it was told last
    mutable std::mutex mutex_;  // of failure_
    std::optional<std::string> failure_;
    std::atomic<bool> failed_{false};
};

/// InputError naming the file when it exists, or when a crash left FILE.part: a recording is never written
/// over another one.
void require_new(const std::filesystem::path& file);

}  // namespace shaker::recording
