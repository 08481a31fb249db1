#pragma once
// A bench on call, without a client: drives start, are recorded, measured and end by the same rules, whoever
// gives the orders.
#include <cmath>
#include <deque>
#include <exception>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "daemon/run/runner.hpp"
#include "daemon/run/walk_prediction.hpp"
#include "drivers/beside.hpp"

namespace shaker::on_call {

/// A finished measurement of a bench on call.
struct Measured {
    recording::FinishedMeasurement measurement;
    std::shared_ptr<const reduction::Reduction> reduction;  // null: it could not be reduced
    std::string not_reduced;                                // reason
    std::string recording;                                  // file name; empty: not recorded
    double true_v_D = NAN;  // m/s, of a simulated walker over the same time; NaN: not known
};

/// Thread safety: one thread. The runner (on call) must outlive this object.
class OnCall {
public:
    /// beside: measurements are reduced in a separate thread. DeviceError when the system grants none.
    OnCall(run::Runner& runner, bool beside);
    OnCall(const OnCall&) = delete;
    OnCall& operator=(const OnCall&) = delete;

    /// Processes new data and starts the reductions of finished measurements. False when no data arrived.
    /// Call it before the orders of a step.
    bool take(const acquisition::Streams& streams, acquisition::Channels& channels);
    /// Keeps recordings and memory up with the sequence. Call it after the orders of a step. run: the present
    /// options, for the record of a stop at rest.
    void follow(const run::RunOptions& run, acquisition::Channels& channels);

    /// InputError unless the drive is in the range of the drives and within these limits.
    void require_possible(const Drive& drive, const safety::Limits& limits) const;
    /// InputError, which names `what`, unless a drive may start now.
    void require_idle(const char* what, const acquisition::Channels& channels) const;
    /// Starts a drive, recorded in `file` (empty: not recorded), as soon as the recorder's thread has opened
    /// it; until then the state is `armed`. walk: the walker's expected way; a walker beyond the edge limit
    /// may start if it certainly leads inwards. InputError when it must not start.
    void begin(const run::RunOptions& run, const run::Task& task, const std::filesystem::path& file,
               const std::optional<run::PredictedWalk>& walk, acquisition::Channels& channels);
    /// The outcome of begin(), once: empty while the file is being opened; then a remark on how far the
    /// walker can go, which is usually empty. Throws InputError or DeviceError when the drive could not
    /// start.
    std::optional<std::string> begun();
    /// Identifies the response for this drive, then silence.
    void identify(const run::RunOptions& run, acquisition::Channels& channels);
    /// A new set-point of a drive that runs. InputError for a new frequency while a recording is open.
    void set(const Drive& drive, const run::Task& task, acquisition::Channels& channels);
    /// Starts to record the present run when the file is open, the drive is steady and has settled again. If
    /// the run ends first, the file is deleted. InputError as begin().
    void record(const run::RunOptions& run, const std::filesystem::path& file);
    /// Ends the recording of the run under way, which goes on.
    void end_recording();
    /// A soft stop; a measurement under way keeps its whole periods. A drive that has not started does not.
    void end(acquisition::Channels& channels);
    /// Clears the trips that were shown. aborts: as run::Sequence::clear(). InputError while the recording of
    /// the stopped run is not finished, and for a trip that came later.
    void clear(std::size_t shown, std::uint64_t aborts, acquisition::Channels& channels);
    /// New limits for all guards, from now on. Detectors stay.
    void hold_to(const safety::Limits& limits, acquisition::Channels& channels);

    [[nodiscard]] const safety::Limits& limits() const noexcept { return limits_; }
    /// The sequence's state; `finishing` while it is idle and a recording is not complete, `armed` while the
    /// file of a start is being opened.
    [[nodiscard]] run::RunState state() const;
    [[nodiscard]] bool may_clear() const { return sequence_.may_clear() && !record_.finishing(); }
    /// Drives and identifications that were begun, also those that a stop ended at once.
    [[nodiscard]] std::uint64_t runs() const noexcept { return runs_; }
    /// Silent, and nothing is left to record.
    [[nodiscard]] bool at_rest() const;
    /// A finished measurement waits for its reduction.
    [[nodiscard]] bool pending() const noexcept { return !pending_.empty(); }
    /// Why a run of N measurements ends now: on its present walk the walker would reach the edge limit before
    /// the next whole measurement, or before this one, is over. Empty: it fits, or is not known.
    [[nodiscard]] std::string way_ends() const;
    /// Predicted peak of the base's displacement from its middle, mm.
    [[nodiscard]] double oscillation_mm(const Drive& drive) const;
    /// The next measurement whose reduction is finished.
    std::optional<Measured> measured();
    /// The next run whose recording is complete.
    std::optional<run::FinishedRun> finished() { return record_.finished(); }

private:
    using Outcome = std::variant<std::shared_ptr<const reduction::Reduction>, std::string>;
    struct Pending {
        Measured measured;
        std::future<Outcome> outcome;
    };
    void may_drive(const run::RunOptions& run, const char* what, const acquisition::Channels& channels) const;
    /// A start whose recording is being opened, or whose outcome nobody has asked for.
    struct Start {
        run::RunOptions run;
        run::Task task;
        std::optional<run::PredictedWalk> walk;
        bool recorded = false;
        std::uint64_t aborts = 0;  // Channels::aborts at begin()
        bool over = false;
        std::string fits{};
        std::exception_ptr failure{};
    };
    /// The recording of a start is being opened.
    [[nodiscard]] bool opening() const noexcept { return start_ && !start_->over; }
    void go_on_with_start(acquisition::Channels& channels);
    void drive(Start& start, acquisition::Channels& channels);
    void note_drive(const Drive& drive);
    [[nodiscard]] std::optional<safety::EdgePermit> walk_from_the_edge(
        const Drive& drive, const std::optional<run::PredictedWalk>& walk) const;
    void require_inside(double edge_mm, const std::string& way_back) const;
    void reduce_finished(const acquisition::Streams& streams);
    void join_recording(acquisition::Channels& channels);
    void tidy();

    run::Runner& runner_;
    bench::Bench& bench_;
    acquisition::Collector& collector_;
    run::Sequence& sequence_;
    run::Recordings& record_;
    Beside reducer_;  // one thread for the life of the bench
    safety::Limits limits_;
    double frequency_;     // of the drive, Hz
    bool active_ = false;  // a run is not finished
    std::optional<Start> start_;
    std::uint64_t runs_ = 0;
    std::optional<std::size_t> recorded_stop_;  // Sequence::cause() of the newest trip that was recorded
    run::RunState state_ = run::RunState::init;
    std::size_t reduced_ = 0;  // measurements of the sequence whose reduction was started
    std::deque<Pending> pending_;
};

}  // namespace shaker::on_call
