#pragma once
// The recordings of a bench's runs: opened before the drive starts, finished on the recorder's thread after
// the soft stop. Also writes the last seconds of stopped runs.
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/collector.hpp"
#include "daemon/bench/bench.hpp"
#include "daemon/recording/folder.hpp"
#include "daemon/run/ended_run.hpp"
#include "daemon/run/recording_monitor.hpp"
#include "daemon/run/run_settings.hpp"
#include "daemon/run/sequence.hpp"
#include "drivers/devices.hpp"

namespace shaker::run {

/// Streams kept for the guards, and for a stop just after a recording.
inline constexpr double kept_streams_s = 12;

struct RecordingsSettings {
    std::filesystem::path folder;  // for named recordings and for the last seconds of stopped runs
    double most_s = 3600;          // longest recording, s
    bool live = false;             // a separate thread calls step()
    bool on_call = false;          // runs follow each other on endless streams
};

/// A name from the time: "run-20260427T101500Z".
std::string stem_now();

/// A finished run with its results and its file.
struct FinishedRun {
    EndedRun run;  // its streams are empty on call
    Results results;
    std::filesystem::path file;  // empty: no file
    bool whole = false;          // true: the file holds the whole run; false: its last seconds
    std::exception_ptr failure;  // reason for an incomplete file; null: complete
    bool abandoned = false;      // true: a device failed (failure); the recording stays FILE.part
    bool data = false;           // after a failure: FILE.part exists
    std::optional<std::string> recorder_failure;  // reason why the recorder stopped during the run
};

/// Thread safety: the recorder's thread calls step(), the thread that leads the run calls everything else.
/// Only begin() waits for the disk. It is called while nothing is driven.
class Recordings {
public:
    /// Bench and collector must outlive this object. On call it locks the folder: InputError when another
    /// daemon has it, DeviceError when it cannot be written.
    Recordings(bench::Bench& bench, acquisition::Collector& collector, const RecordingsSettings& settings);

    /// Path of a recording in the folder. name: without folder and ending; empty: the path ends with "/", and
    /// the file gets its name from the time at which it is opened.
    [[nodiscard]] std::filesystem::path file_named(const std::string& name) const;
    /// Prepares the run's header and opens its file (empty path: no file). now_s: master time, s. InputError
    /// when the file exists, and while the previous recording is being finished.
    void begin(const RunOptions& run, const std::filesystem::path& file, double now_s);
    /// On call: opens a file on the recorder's thread. InputError as begin().
    enum class For { run_under_way, start };
    void prepare(const RunOptions& run, const std::filesystem::path& file, double now_s, For what);
    /// The file is being opened; then it is open, or cannot be.
    [[nodiscard]] bool opening() const;
    /// For a start: the run begins, and its data go to the prepared file. Throws why it could not be opened.
    void begin_prepared();
    /// A file was prepared and no run has joined it. Any thread.
    [[nodiscard]] bool preparing() const;
    /// The prepared file is open.
    [[nodiscard]] bool prepared() const;
    /// The data from now on go to the prepared file. No measurement may be under way.
    void join(const Sequence& sequence);
    /// Has the recorder's thread remove the prepared file. Does nothing when no file was prepared.
    void discard();
    /// Call it after each step of the sequence. Ends the run when its recording becomes too long.
    void update(Sequence& sequence, acquisition::Channels& channels);
    /// Adds the operator's remark to the open recording, or to the next one when no recording is open.
    void remark(const std::string& text, const Sequence& sequence);
    /// Call it when the drive is silent, or while it runs on without recording. Passes the files to the
    /// recorder's thread for completion. Without `live`, they are complete on return.
    void finish(const Sequence& sequence);
    /// The run up to the failure of a device, with results. Its recording stays FILE.part.
    [[nodiscard]] FinishedRun abandon(const Sequence& sequence, std::exception_ptr why);
    /// True while a file is being completed.
    [[nodiscard]] bool finishing() const noexcept { return unfinished_ > 0; }
    /// Grows with every step of the completion of a file: measurements reduced, pictures cut. Any thread.
    [[nodiscard]] std::uint64_t progress() const noexcept { return progress_; }
    /// The next finished run whose file is complete; empty while there is no such run.
    std::optional<FinishedRun> finished();
    /// Warnings of the guards since begin(), one sentence per cause.
    [[nodiscard]] std::vector<std::string> warnings() const;

    [[nodiscard]] const std::filesystem::path& folder() const noexcept { return settings_.folder; }
    /// Longest recording, s.
    [[nodiscard]] double most_s() const noexcept { return settings_.most_s; }
    /// File name of the recording that is open or being finished; empty without one.
    [[nodiscard]] std::string name() const;
    /// Filled share of the recorder's queue (0 to 1), and pieces of data lost because it was full.
    [[nodiscard]] double backlog() const { return on() ? recording_->backlog() : 0; }
    [[nodiscard]] std::uint64_t pieces_lost() const { return on() ? recording_->lost() : 0; }
    [[nodiscard]] recording::RecordedRate rate() const;
    /// Free space in the folder, bytes, at most half a second old; NaN: not known.
    [[nodiscard]] double free_bytes() const noexcept { return free_bytes_; }
    [[nodiscard]] bool on() const noexcept { return recording_ != nullptr; }
    /// Writes waiting data or completes a file. False when there was nothing to do.
    bool step();

private:
    struct Job {
        FinishedRun run;
        std::shared_ptr<recording::Recorder> recording;  // null: the run was not recorded
        double lasted_s = 0;                             // the recording
    };
    struct Prepared {
        std::filesystem::path file;
        recorded::RecordingHeader header;
        double started_s = 0;
        For what = For::run_under_way;
        bool learns = false;                               // the targets' places in its pictures
        std::exception_ptr failure{};                      // of a start: why the file cannot be opened
        std::shared_ptr<recording::Recorder> recording{};  // null: not open yet
        bool unwanted = false;
    };
    using Counts = std::array<std::uint64_t, safety::causes>;

    void require_free() const;
    void count_from_now();
    [[nodiscard]] recording::RecorderSettings settings_for(double started_s);
    void start(const std::filesystem::path& file, std::shared_ptr<recording::Recorder> recording);
    bool open_prepared();
    [[nodiscard]] std::shared_ptr<Prepared> take_prepared();
    [[nodiscard]] std::filesystem::path free_name() const;
    [[nodiscard]] EndedRun ended(const Sequence& sequence) const;
    void conclude(Job& job);
    void ask_for_space();

    bench::Bench& bench_;
    acquisition::Collector& collector_;
    RecordingsSettings settings_;
    h5::FileLock folder_;  // on call only
    recorded::RecordingHeader header_;
    double started_s_ = 0;              // master time of the date in the header
    std::size_t notes_before_ = 0;      // notes of the sequence from before the recording
    std::vector<DeviceReport> before_;  // device counts at begin()
    Counts warned_{};                   // warning counts at begin()
    std::filesystem::path file_;
    std::shared_ptr<recording::Recorder> recording_;  // changed under mutex_
    std::unique_ptr<RecordingMonitor> watch_;
    std::string closing_;      // file name of the recording being finished; empty: the run was not recorded
    double begun_s_ = 0;       // master time of the first update with this recording
    bool ended_long_ = false;  // the run was ended because its recording became too long
    std::deque<recording::LogEntry> remarks_;  // for the next recording, at most most_remarks

    std::atomic<int> unfinished_{0};
    std::atomic<std::uint64_t> progress_{0};
    std::atomic<double> free_bytes_{NAN};
    std::chrono::steady_clock::time_point asked_{};  // last query of the free space
    mutable std::mutex mutex_;  // guards recording_, prepared_, jobs_, finished_, rate_; held briefly
    std::shared_ptr<Prepared> prepared_;
    std::deque<std::unique_ptr<Job>> jobs_;
    std::deque<FinishedRun> finished_;
    recording::RecordedRate rate_;
};

inline constexpr std::size_t most_remarks = 100;

}  // namespace shaker::run
