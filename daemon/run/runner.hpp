#pragma once
// Leads any run on a bench: a single run, a bench on call, or a self-test.
#include <atomic>
#include <functional>
#include <vector>

#include "daemon/acquisition/run_loops.hpp"
#include "daemon/bench/bench.hpp"
#include "daemon/run/recordings.hpp"
#include "daemon/run/run_settings.hpp"
#include "daemon/run/self_test.hpp"
#include "daemon/run/sequence.hpp"

namespace shaker::run {

struct RunnerSettings {
    RunOptions run;
    bool on_call = false;  // waits in idle for orders and is never done
    /// Folder for named recordings and for the last seconds of stopped runs.
    std::filesystem::path recordings = ".";
    double longest_recording_s = 3600;  // on call only
    bool commissioning = false;         // drives a bench that has not been commissioned
};

/// Owns an opened bench and the loops that drive and measure it. Limits, refusals, warnings and recordings
/// are the same for every kind of run.
/// Thread safety: one thread; lead() starts the loops' threads and joins them.
class Runner {
public:
    /// Opens the bench and builds the loops; nothing is driven and no file is made. InputError or DeviceError
    /// as bench::open_bench().
    explicit Runner(const RunnerSettings& settings);
    Runner(const Runner&) = delete;
    Runner& operator=(const Runner&) = delete;

    /// Performs the run of the settings: drives, measures, stops softly, records. InputError for a drive
    /// beyond the limits and as require_commissioned(), before anything moves or any file is made. A device
    /// that fails ends it: the run is then abandoned, with the results so far.
    FinishedRun run();
    /// Runs a self-test and judges it. A stop by a limit and a failed device are findings too.
    std::vector<Finding> check(SelfTestPlan plan);
    /// Runs the loops until `done` returns true. Calls `step` after new data. A loop that fails: the drive
    /// ramps to zero, then the exception is thrown from here.
    void lead(const acquisition::Lead& step, const std::function<bool()>& done);
    /// Asks run() and check() to end: the first request with a soft stop, a further one with an abort. Any
    /// thread and signal handlers.
    void request_stop() noexcept { ++stop_requests_; }
    [[nodiscard]] int stop_requests() const noexcept { return stop_requests_; }
    /// DeviceError when the operating system refused real-time scheduling or locked memory and the rig file
    /// requires them.
    void require_real_time() const;
    /// InputError when the bench is real hardware without a valid record of its commissioning, unless the
    /// settings allow it, and when a mixer has changed since the bench was opened.
    void require_commissioned() const;

    [[nodiscard]] bench::Bench& bench() noexcept { return bench_; }
    [[nodiscard]] acquisition::Collector& collector() noexcept { return collector_; }
    [[nodiscard]] Sequence& sequence() noexcept { return sequence_; }
    [[nodiscard]] Recordings& recordings() noexcept { return recordings_; }
    [[nodiscard]] const RunOptions& options() const noexcept { return settings_.run; }
    [[nodiscard]] const safety::Limits& limits() const noexcept { return limits_; }
    /// Time that the DAC has played, and the elapsed real time, s.
    [[nodiscard]] double played_s() const noexcept;
    [[nodiscard]] double wall_s() const noexcept { return wall_s_; }
    /// Requests for real time and the operating system's answers, from the first step on. Simulated rigs:
    /// none.
    [[nodiscard]] const std::vector<acquisition::RealTimeGrant>& real_time() const noexcept {
        return real_time_;
    }

private:
    RunnerSettings settings_;
    bench::Bench bench_;
    bool live_;  // one thread per loop
    safety::Limits limits_;
    acquisition::Collector collector_;
    acquisition::DriveOutput output_;
    Sequence sequence_;
    Recordings recordings_;
    commissioned::MixerChange changed_mixers(double now_s);
    void watch_mixers(acquisition::Channels& channels);
    void obey_stop_requests(acquisition::Channels& channels);
    void tidy();

    double wall_s_ = 0;
    std::vector<acquisition::RealTimeGrant> real_time_;
    std::atomic<int> stop_requests_{0};
    int obeyed_ = 0;            // stop requests
    double mixers_read_s_ = 0;  // master time
};

}  // namespace shaker::run
