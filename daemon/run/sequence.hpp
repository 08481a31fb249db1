#pragma once
// Leads one run through its states: silence, identification, soft start, settling with the measured harmonics
// correcting the drive, measuring, soft stop.
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/channels.hpp"
#include "daemon/acquisition/streams.hpp"
#include "daemon/control/drive_controller.hpp"
#include "daemon/control/period_windows.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/run/drive_in_force.hpp"
#include "daemon/run/states.hpp"
#include "daemon/run/supervisor.hpp"
#include "daemon/run/walker_monitor.hpp"

namespace shaker::run {

struct RunPlan {
    control::ControllerSettings controller;
    double line_hz = 0;        // mains, fitted beside the harmonics; 0: not
    int periods = 40;          // to measure
    int settle = 0;            // of the settled drive before them; 0: until the walker is steady
    int soft_start = 10;       // periods of the ramps at both ends
    int settle_at_most = 400;  // periods; then it measures all the same and says so
    int most_restarts = 3;     // after the DAC ran empty; then the run fails
    double quiet_s = 0.6;      // of silence before the drive
    safety::Limits limits;     // what stops the drive
    double gravity = paper_g;  // m/s^2 at the place
    bool on_call = false;      // waits in idle for begin(), measures until end() and never is done()
};

/// A state machine over what has been gathered. It reads the take and answers with drive commands: nothing
/// else.
class Sequence {
public:
    using Say = std::function<void(const std::string&)>;
    Sequence(const RunPlan& plan, double dac_rate_hz, const AccelerometerInfo& accelerometer, Say say);

    /// Looks at what came since the last call and posts a command when the drive should change. False when
    /// nothing had come.
    bool step(const acquisition::Streams& streams, acquisition::Channels& channels);
    /// On call and in idle: goes for `drive`, with the response found out first where it is not known, and
    /// measures so many periods again and again; settle: as in RunPlan. InputError in any other state.
    void begin(const Drive& drive, int periods, int settle, acquisition::Channels& channels);
    /// On call and in idle: whether measured harmonics correct the drive from the next begin() on. InputError
    /// in any other state.
    void close_loop(bool on);
    /// On call and in idle: finds out the response anew, for this drive; then it is silent again. InputError
    /// in any other state, and where responses are not found out.
    void identify(const Drive& drive, acquisition::Channels& channels);
    /// On call: a soft stop, and idle. InputError when it is not driving.
    void end(acquisition::Channels& channels);
    /// A new set-point while it runs: the drive goes there over one period, settles and is measured anew.
    void set(const Drive& drive, acquisition::Channels& channels);
    /// Other levels from now on, for all that guard.
    void hold_to(const safety::Limits& limits, acquisition::Channels& channels);
    /// The run is stopped from outside: a ramp to zero at once, which counts as a trip.
    void stop(acquisition::Channels& channels,
              const safety::Trip& why = {.cause = safety::Cause::operator_stop});
    /// The operator has seen why it tripped: idle again as soon as the output has let go. InputError when
    /// nothing is to be cleared or the drive is not silent yet.
    void clear(acquisition::Channels& channels);

    [[nodiscard]] const RunPlan& plan() const noexcept { return plan_; }
    [[nodiscard]] RunState state() const noexcept { return named(state_); }
    /// The run is over and the shaker silent.
    [[nodiscard]] bool done() const noexcept;
    /// Part of master time that was measured, s; whole periods of the drive.
    [[nodiscard]] double from_s() const noexcept { return part_.from_s; }
    [[nodiscard]] double to_s() const noexcept { return part_.to_s; }
    /// The measurements since begin() that are finished, the newest last.
    [[nodiscard]] const std::vector<recording::FinishedMeasurement>& measured() const noexcept {
        return measured_;
    }
    /// Silent after a trip: clear() may follow.
    [[nodiscard]] bool may_clear() const noexcept;
    /// Master time played, s, and since when it has been in state().
    [[nodiscard]] double now_s() const noexcept { return now_s_; }
    [[nodiscard]] double since_s() const noexcept { return since_s_; }
    /// The newest period of the base's motion; none before the first.
    [[nodiscard]] const std::optional<control::PeriodWindows::Window>& newest() const noexcept {
        return newest_;
    }
    [[nodiscard]] const control::PeriodWindows& windows() const noexcept { return windows_; }
    [[nodiscard]] const WalkerMonitor& walker() const noexcept { return walker_; }
    /// What a reader of the results should know of how the run went; since begin(), when on call.
    [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
    /// Why the drive was stopped; empty unless it was.
    [[nodiscard]] const std::optional<safety::Trip>& trip() const noexcept { return trip_; }
    /// What the run was at when each trip of the take happened.
    struct Stop {
        RunState state;
        bool measuring;  // from_s() to to_s(), which may have been over
    };
    [[nodiscard]] const std::vector<Stop>& stops() const noexcept { return stops_; }
    /// Which trip of the take is trip(): the last of those that did not come in state tripped.
    [[nodiscard]] std::size_t cause() const noexcept { return cause_; }
    [[nodiscard]] const control::DriveController& controller() const noexcept { return controller_; }

protected:
    /// Enters a state. Where that cannot follow the present one, the drive is stopped instead, with a note: a
    /// defect of the sequence must not leave the shaker without a leader.
    void go(const State& next, acquisition::Channels& channels);

private:
    void aim(const char* what, const Drive& drive, const acquisition::Channels& channels);
    void come_down(acquisition::Channels& channels);
    void take_trips(const acquisition::Streams& streams, acquisition::Channels& channels);
    void take_stamps(const acquisition::Streams& streams, acquisition::Channels& channels);
    void start_again(std::int64_t lost, acquisition::Channels& channels);
    void blame_dac(Tripped& tripped);
    void arm(acquisition::Channels& channels);
    void take_accelerations(const acquisition::Streams& streams, acquisition::Channels& channels);
    void window_done(const control::PeriodWindows::Window& window, const calibration::Timebase& timebase,
                     acquisition::Channels& channels);
    void identified(acquisition::Channels& channels);
    void tell(const control::PeriodWindows::Window& window);
    void start(acquisition::Channels& channels);
    void go_for_target(int ramp_periods, acquisition::Channels& channels);
    void begin_measuring(bool late);
    void note_on_settling(bool late);
    void note(const std::string& what);
    void command(const Harmonics<Voltage>& volts, int ramp_periods, bool transient,
                 acquisition::Channels& channels);
    [[nodiscard]] bool stragglers_may_come();
    [[nodiscard]] bool walker_settled() const;

    // What each state waits for.
    void advance(Init& init, acquisition::Channels& channels);
    void advance(Quiet& quiet, acquisition::Channels& channels);
    void advance(Idle& /*idle*/, acquisition::Channels& /*channels*/) {}
    void advance(Armed& /*armed*/, acquisition::Channels& /*channels*/) {}
    void advance(Identify& /*identify*/, acquisition::Channels& /*channels*/) {}
    void advance(Ramp& ramp, acquisition::Channels& channels);
    void advance(Run& run, acquisition::Channels& channels);
    void advance(RampDown& down, acquisition::Channels& channels);
    void advance(Tripped& tripped, acquisition::Channels& channels);
    void settle(Run& run);
    void unlatch(Tripped& tripped, acquisition::Channels& channels);
    void finish_clearing(acquisition::Channels& channels);

    RunPlan plan_;
    double dac_rate_hz_;
    double frequency_;  // as it is really played, Hz
    Say say_;
    control::PeriodWindows windows_;
    control::DriveController controller_;
    WalkerMonitor walker_;
    Supervisor guard_;
    DriveInForce drive_;

    State state_;
    double since_s_ = 0;  // master time of its beginning
    /// What was ordered and how far that has come, over all states.
    struct Order {
        bool only_identify = false;  // silence follows the identification
        bool told_settling = false;  // the notes on how it settled are written, for this set-point
        int restarts = 0;            // after the DAC ran empty
    } order_;
    static constexpr double aftermath_s = 0.3;  // recorded after a trip
    struct Lost {
        std::int64_t samples = 0;
        double at_s = -INFINITY;  // master time
    } lost_;                      // when the DAC ran empty last

    std::vector<Stop> stops_;  // one a trip
    std::size_t cause_ = 0;    // index of the one that stopped it
    std::optional<safety::Trip> trip_;
    std::size_t plays_ = 0, blocks_ = 0, changes_ = 0;  // how much of the streams has been seen
    AccelTick last_tick_{};                             // of the accelerometer
    bool clocks_known_ = false;                         // of DAC and accelerometer
    double now_s_ = 0;                                  // master time played
    double told_s_ = 0;                                 // of the period that was reported last
    recording::MeasuredPart part_{0, 0};                // the newest measurement that began
    std::vector<recording::FinishedMeasurement> measured_;
    std::optional<control::PeriodWindows::Window> newest_;
    std::vector<std::string> notes_;
};

}  // namespace shaker::run
