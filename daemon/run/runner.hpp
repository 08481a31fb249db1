#pragma once
// Leads any run on a bench: one order and an exit, orders from outside, or a self-test.
#include <functional>
#include <string>
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
    bool on_call = false;  // waits in idle for orders and never is done
    std::filesystem::path recordings =
        ".";                            // folder for recordings by name and for stopped runs' last seconds
    double longest_recording_s = 3600;  // on call
};

/// Owns an opened bench with everything that drives and hears it. Whoever leads, the same limits are in
/// force, the same drives are refused, the same warnings are counted and the same recordings are made. Thread
/// safety: one thread; lead() starts the loops' threads and joins them.
class Runner {
public:
    /// Opens the bench and builds the loops; nothing is driven and no file is made. InputError or DeviceError
    /// as bench::open_bench().
    explicit Runner(const RunnerSettings& settings);
    Runner(const Runner&) = delete;
    Runner& operator=(const Runner&) = delete;

    /// Executes the order of the settings: drives, measures, comes down, records. InputError, before anything
    /// moves and any file is made, for a drive beyond the limits. DeviceError for a device that fails.
    FinishedRun run();
    /// Plays a self-test and judges it. A limit that stops it and a device that fails are findings too.
    std::vector<Finding> check(SelfTestPlan plan);
    /// Calls `step` after new data until `done`; the loops play, hear and record meanwhile.
    void lead(const acquisition::Lead& step, const std::function<bool()>& done);

    [[nodiscard]] bench::Bench& bench() noexcept { return bench_; }
    [[nodiscard]] acquisition::Collector& collector() noexcept { return collector_; }
    [[nodiscard]] Sequence& sequence() noexcept { return sequence_; }
    [[nodiscard]] Recordings& recordings() noexcept { return recordings_; }
    [[nodiscard]] const RunOptions& options() const noexcept { return settings_.run; }
    [[nodiscard]] const safety::Limits& limits() const noexcept { return limits_; }
    /// Time the DAC has played, and that this took, s.
    [[nodiscard]] double played_s() const noexcept;
    [[nodiscard]] double wall_s() const noexcept { return wall_s_; }
    /// The operating system's refusals of real-time requests.
    [[nodiscard]] const std::vector<std::string>& refused() const noexcept { return refused_; }

private:
    RunnerSettings settings_;
    bench::Bench bench_;
    bool live_;  // one thread a loop
    safety::Limits limits_;
    acquisition::Collector collector_;
    acquisition::DriveOutput output_;
    Sequence sequence_;
    Recordings recordings_;
    double wall_s_ = 0;
    std::vector<std::string> refused_;
};

}  // namespace shaker::run
