#pragma once
// Leads one run through its states: silence, identification, soft start, settling with the measured harmonics
// correcting the drive, measuring, soft stop.
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/drive_keeper.hpp"
#include "daemon/lanes.hpp"
#include "daemon/motion_windows.hpp"
#include "daemon/run_guard.hpp"
#include "daemon/run_log.hpp"
#include "daemon/run_states.hpp"
#include "daemon/take.hpp"
#include "daemon/walker_watch.hpp"

namespace shaker {

struct RunPlan {
    KeeperSettings keeper;
    double line_hz = 0;        // mains, fitted beside the harmonics; 0: not
    int periods = 40;          // to measure
    int settle = 0;            // of the settled drive before them; 0: until the walker is steady
    int soft_start = 10;       // periods of the ramps at both ends
    int settle_at_most = 400;  // periods; then it measures all the same and says so
    int most_restarts = 3;     // after the DAC ran empty; then the run fails
    double quiet_s = 0.6;      // of silence before the drive
    Limits limits;             // what stops the drive
    bool on_call = false;      // waits in idle for begin(), measures until end() and never is done()
};

/// A state machine over what has been gathered. It reads the take and answers with drive commands: nothing
/// else.
class Director {
public:
    using Say = std::function<void(const std::string&)>;
    Director(const RunPlan& plan, double dac_rate_hz, const AccelerometerInfo& accelerometer, Say say);

    /// Looks at what came since the last call and posts a command when the drive should change. False when
    /// nothing had come.
    bool step(const Take& take, Lanes& lanes);
    /// On call and in idle: goes for `drive`, with the response found out first where it is not known, and
    /// measures so many periods again and again; settle: as in RunPlan. InputError in any other state.
    void begin(const Drive& drive, int periods, int settle, Lanes& lanes);
    /// On call and in idle: whether measured harmonics correct the drive from the next begin() on. InputError
    /// in any other state.
    void close_loop(bool on);
    /// On call and in idle: finds out the response anew, for this drive; then it is silent again. InputError
    /// in any other state, and where responses are not found out.
    void identify(const Drive& drive, Lanes& lanes);
    /// On call: a soft stop, and idle. InputError when it is not driving.
    void end(Lanes& lanes);
    /// A new set-point while it runs: the drive goes there over one period, settles and is measured anew.
    void set(const Drive& drive, Lanes& lanes);
    /// Other levels from now on, for all that guard.
    void hold_to(const Limits& limits, Lanes& lanes);
    /// The run is stopped from outside: a ramp to zero at once, which counts as a trip.
    void stop(Lanes& lanes, const Trip& why = {.cause = Cause::operator_stop});
    /// The operator has seen why it tripped: idle again as soon as the output has let go. InputError when
    /// nothing is to be cleared or the drive is not silent yet.
    void clear(Lanes& lanes);

    [[nodiscard]] RunState state() const noexcept { return state_; }
    /// The run is over and the shaker silent.
    [[nodiscard]] bool done() const noexcept { return done_; }
    /// Part of master time that was measured, s; whole periods of the drive.
    [[nodiscard]] double from_s() const noexcept { return from_s_; }
    [[nodiscard]] double to_s() const noexcept { return to_s_; }
    /// The measurements since begin() that are complete, the newest last.
    [[nodiscard]] const std::vector<MeasuredPart>& measured() const noexcept { return measured_; }
    /// Silent after a trip: clear() may follow.
    [[nodiscard]] bool may_clear() const noexcept { return state_ == RunState::tripped && done_; }
    /// Master time played, s, and since when it has been in state().
    [[nodiscard]] double now_s() const noexcept { return now_s_; }
    [[nodiscard]] double since_s() const noexcept { return since_s_; }
    /// The newest period of the base's motion; none before the first.
    [[nodiscard]] const std::optional<MotionWindows::Window>& newest() const noexcept { return newest_; }
    [[nodiscard]] const MotionWindows& windows() const noexcept { return windows_; }
    [[nodiscard]] const WalkerWatch& walker() const noexcept { return walker_; }
    /// What a reader of the results should know of how the run went; since begin(), when on call.
    [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
    /// Why the drive was stopped; empty unless it was.
    [[nodiscard]] const std::optional<Trip>& trip() const noexcept { return trip_; }
    /// What the run was at when each trip of the take happened.
    struct Stop {
        RunState state;
        bool measuring;  // from_s() to to_s(), which may have been over
    };
    [[nodiscard]] const std::vector<Stop>& stops() const noexcept { return stops_; }
    /// Which trip of the take is trip(): the last of those that did not come in state tripped.
    [[nodiscard]] std::size_t cause() const noexcept { return cause_; }
    [[nodiscard]] const DriveKeeper& keeper() const noexcept { return keeper_; }

private:
    void go(RunState next);
    void aim(const char* what, const Drive& drive, const Lanes& lanes);
    void come_down(Lanes& lanes);
    void take_trips(const Take& take);
    void take_stamps(const Take& take, Lanes& lanes);
    void start_again(std::int64_t lost, Lanes& lanes);
    void blame_dac();
    void unlatch(Lanes& lanes);
    void finish_clearing(const Lanes& lanes);
    void arm(Lanes& lanes);
    void take_accelerations(const Take& take, Lanes& lanes);
    void window_done(const MotionWindows::Window& window, Lanes& lanes);
    void tell(const MotionWindows::Window& window);
    void advance(Lanes& lanes);
    void start(Lanes& lanes);
    void go_for_target(int ramp_periods, Lanes& lanes);
    void begin_measuring(bool late);
    void note(const std::string& what);
    void command(const Harmonics<Voltage>& volts, int ramp_periods, bool transient, Lanes& lanes);
    [[nodiscard]] bool stragglers_may_come();
    [[nodiscard]] bool walker_settled() const;

    RunPlan plan_;
    double dac_rate_hz_;
    double frequency_;  // as it is really played, Hz
    Say say_;
    MotionWindows windows_;
    DriveKeeper keeper_;
    WalkerWatch walker_;
    RunGuard guard_;
    RunState state_ = RunState::init;
    bool done_ = false, measuring_ = false;
    bool only_identify_ = false, told_late_ = false;
    std::size_t plays_ = 0, blocks_ = 0, changes_ = 0;  // how much of the take has been seen
    std::uint64_t sequence_ = 0;
    std::uint64_t awaited_ = 0;  // command that ends the state once it is in force
    int restarts_ = 0;
    std::int64_t lost_ = 0;      // samples, when the DAC ran empty last
    double lost_s_ = -INFINITY;  // and where
    bool excused_ = false;       // the trip: it was the DAC's fault, and the drive may come back
    bool released_ = false, clearing_ = false;
    std::vector<Stop> stops_;  // one a trip
    std::size_t cause_ = 0;    // which of them stopped it
    std::optional<Trip> trip_;
    double tripped_s_ = 0;
    AccelTick last_tick_{};              // of the accelerometer
    double now_s_ = 0, since_s_ = 0;     // master time played
    double told_s_ = 0;                  // of the period that was told last
    double steady_from_s_ = 0;           // the newest large change of the drive has been in effect since
    double in_force_s_ = 0;              // of the awaited command; infinite while it is not
    std::uint64_t target_sequence_ = 0;  // command that goes for the present target first
    double target_from_s_ = INFINITY;    // it has been in force since; infinite while it is not
    double kept_from_s_ = -INFINITY;     // the drive has been where it should be, while it settles
    double run_from_s_ = 0, from_s_ = 0, to_s_ = 0;
    std::vector<MeasuredPart> measured_;
    std::optional<MotionWindows::Window> newest_;
    std::vector<std::string> notes_;
};

}  // namespace shaker
