#pragma once
// The recording of one run of a daemon: opened before the drive comes up, finished when it is silent again,
// and what a stopped run leaves behind.
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "daemon/acquisition.hpp"
#include "daemon/bench_state.hpp"
#include "daemon/commands.hpp"
#include "daemon/director.hpp"
#include "daemon/recording_watch.hpp"
#include "daemon/rigs.hpp"

namespace shaker {

struct RunRecordSettings {
    std::filesystem::path folder;  // of recordings and of stopped runs' last seconds
    bool live = false;             // a thread of its own calls step()
    double most_s = 3600;          // of one recording: all of it is in memory until it is finished
};

/// All but step() is for the session's thread, and waits for the disk: only while nothing is driven.
class RunRecord {
public:
    /// Bench and acquisition outlive this.
    RunRecord(OpenRig& bench, Acquisition& acquisition, const RunRecordSettings& settings)
        : bench_{bench}, acquisition_{acquisition}, settings_{settings} {}

    /// Begins the run's header and, with `record`, its file. name: without folder and ending, of letters,
    /// digits, dots, hyphens and underscores; empty: by the time. InputError for another name or one that
    /// exists.
    void begin(const RunOptions& run, bool record, const std::string& name);
    /// After each step of the director. A recording that becomes too long ends the run.
    void look(Director& director, Lanes& lanes);
    /// What the operator remarks: into the recording that grows, else into the next.
    void remark(const std::string& text, const Director& director);
    /// The run is over, the drive silent: finishes the file. Says where, or why not; empty: nothing was
    /// recorded.
    std::string finish(const Director& director);
    /// It was stopped: the file, or one of the last seconds.
    std::string finish_stopped(const Director& director);

    /// What the desk is told; its thread's.
    [[nodiscard]] RecordingState state() const;
    [[nodiscard]] bool on() const noexcept { return recording_ != nullptr; }
    /// The recorder's thread.
    bool step();

private:
    void open(const std::string& name);
    void close();

    OpenRig& bench_;
    Acquisition& acquisition_;
    RunRecordSettings settings_;
    SessionHeader header_;
    std::vector<DeviceReport> before_;  // the run
    KeptPictures pictures_{};
    std::filesystem::path file_;
    std::mutex mutex_;  // of recording_, between the two threads
    std::unique_ptr<Recording> recording_;
    std::unique_ptr<RecordingWatch> watch_;
    double begun_s_ = 0;
    bool told_long_ = false;
    std::deque<LogEntry> remarks_;  // for the next recording, at most most_remarks
};

inline constexpr std::size_t most_remarks = 100;

/// A recording's name as it may come from a network: 1 to 64 letters, digits, dots, hyphens and underscores,
/// no dot in front. InputError naming it otherwise.
void require_name(const std::string& name);
/// A remark likewise: 1 to 400 bytes of UTF-8 without control characters.
void require_remark(const std::string& text);

}  // namespace shaker
