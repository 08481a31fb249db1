#pragma once
// The recordings of a bench's runs: opened before the drive comes up, finished on the recorder's thread when
// it is silent again, and the files that stopped runs leave behind.
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
#include "daemon/run/ended_run.hpp"
#include "daemon/run/recording_monitor.hpp"
#include "daemon/run/run_settings.hpp"
#include "daemon/run/sequence.hpp"
#include "drivers/device_report.hpp"

namespace shaker::run {

struct RecordingsSettings {
    std::filesystem::path folder;  // of recordings by name and of stopped runs' last seconds
    double most_s = 3600;          // of one recording: all of it is in memory until it is finished
    bool live = false;             // a thread of its own calls step()
    bool on_call = false;          // one run follows the other, on streams that never end
};

/// A run that is over, with its results and its file.
struct FinishedRun {
    EndedRun run;  // on call without streams
    Results results;
    std::filesystem::path file;  // empty: nothing was to be written
    bool whole = false;          // the file is the recording of the whole run, else its last seconds
    std::exception_ptr failure;  // why the file is not complete; null when it is
    std::optional<std::string> recorder_failure;  // why the recorder gave up during the run
};

/// Thread safety: step() is for the recorder's thread, everything else for the thread that leads the run.
/// Only begin() and file_named() wait for the disk: while nothing is driven.
class Recordings {
public:
    /// Bench and collector outlive this.
    Recordings(bench::Bench& bench, acquisition::Collector& collector, const RecordingsSettings& settings);

    /// The file of a recording in the folder; name: without folder and ending; empty: by the time, new.
    [[nodiscard]] std::filesystem::path file_named(const std::string& name) const;
    /// Begins the run's header and, unless it is empty, its file. now_s: master time. InputError for a file
    /// that exists and while the recording before is being finished.
    void begin(const RunOptions& run, const std::filesystem::path& file, double now_s);
    /// After each step of the sequence. A recording that becomes too long ends the run.
    void look(Sequence& sequence, acquisition::Channels& channels);
    /// Adds the operator's remark to the recording that grows, else to the next.
    void remark(const std::string& text, const Sequence& sequence);
    /// The run is over, the drive silent: what there is to complete or to write goes to the recorder's
    /// thread. Not live, all is done on return.
    void finish(const Sequence& sequence);
    /// A file is being completed.
    [[nodiscard]] bool finishing() const noexcept { return unfinished_ > 0; }
    /// The next run whose file has been completed; empty: none.
    std::optional<FinishedRun> finished();
    /// Warnings of the guards since begin(), one sentence a cause.
    [[nodiscard]] std::vector<std::string> warnings() const;

    [[nodiscard]] const std::filesystem::path& folder() const noexcept { return settings_.folder; }
    /// Name of the recording that grows or is being finished; empty: there is none.
    [[nodiscard]] std::string name() const;
    /// What waits to be written, as a share of what may wait, and the pieces of data that found no room.
    [[nodiscard]] double backlog() const { return on() ? recording_->backlog() : 0; }
    [[nodiscard]] std::uint64_t pieces_lost() const { return on() ? recording_->lost() : 0; }
    /// Free space where recordings go, bytes, half a second old; NaN: not known.
    [[nodiscard]] double free_bytes() const noexcept { return free_bytes_; }
    [[nodiscard]] bool on() const noexcept { return recording_ != nullptr; }
    /// Records, or completes a file. False when nothing waited.
    bool step();

private:
    struct Job {
        FinishedRun run;
        std::shared_ptr<recording::Recorder> recording;  // null: not recorded
    };
    using Counts = std::array<std::uint64_t, safety::causes>;

    void open(const std::filesystem::path& file);
    void conclude(Job& job) const;
    void ask_for_space();

    bench::Bench& bench_;
    acquisition::Collector& collector_;
    RecordingsSettings settings_;
    recorded::RecordingHeader header_;
    double started_s_ = 0;              // master time of its date
    std::vector<DeviceReport> before_;  // the run
    Counts warned_{};                   // before the run
    std::filesystem::path file_;
    std::shared_ptr<recording::Recorder> recording_;  // changed under mutex_
    std::unique_ptr<RecordingMonitor> watch_;
    std::string closing_;  // name of the recording that is finished last; empty: it was not recorded
    double begun_s_ = 0;
    bool told_long_ = false;
    std::deque<recording::LogEntry> remarks_;  // for the next recording, at most most_remarks

    std::atomic<int> unfinished_{0};
    std::atomic<double> free_bytes_{NAN};
    std::chrono::steady_clock::time_point asked_{};  // for the free space
    mutable std::mutex mutex_;                       // between the two threads: held for a moment only
    std::deque<std::unique_ptr<Job>> jobs_;
    std::deque<FinishedRun> finished_;
};

inline constexpr std::size_t most_remarks = 100;

}  // namespace shaker::run
