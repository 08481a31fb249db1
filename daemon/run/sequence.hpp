#pragma once
// Leads one run through its states: silence, identification, soft start, settling, measurement, soft stop.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/channels.hpp"
#include "daemon/acquisition/streams.hpp"
#include "daemon/control/drive_controller.hpp"
#include "daemon/control/period_windows.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/run/base_monitor.hpp"
#include "daemon/run/state.hpp"
#include "daemon/run/supervisor.hpp"
#include "daemon/run/walk_prediction.hpp"
#include "daemon/run/walker_monitor.hpp"
#include "daemon/safety/edge_permit.hpp"
#include "drivers/point_fields.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/time.hpp"

namespace shaker::run {

/// What a drive is for: a number of measurements, or only a move of the walker.
struct Task {
    MeasurementPlan plan{};
    bool identifies = true;  // from rest: the response of the base first, if it is not known
    bool operator==(const Task&) const = default;
};

/// A measurement that is ended before its time keeps its whole periods when it has at least as many.
inline constexpr int least_kept_periods = 5;

/// Numbers the drive commands and follows their start at the output. Times are master time, s.
class DriveInForce {
public:
    explicit DriveInForce(double dac_rate_hz) : dac_rate_hz_{dac_rate_hz} {}

    /// The number of the next command.
    std::uint64_t next() noexcept { return ++sequence_; }
    /// The newest command is a large change: no period counts as settled until the command is in force.
    void await() noexcept {
        awaited_ = sequence_;
        in_force_s_ = steady_from_s_ = INFINITY;
    }
    /// The newest command is the first one for the present target.
    void aim() noexcept {
        target_sequence_ = sequence_;
        target_from_s_ = INFINITY;
    }
    /// A change that the output has started. transient_s: settling time of the suspension, s.
    void add(const DriveChange& c, double transient_s) noexcept {
        // Number 0 is the stop of a trip, or the silence after lost time; the ramp up from it follows later.
        if (c.command.sequence < awaited_ || c.command.sequence == 0) return;
        in_force_s_ = counted_s(c.end(), dac_rate_hz_);
        if (c.command.sequence >= target_sequence_) target_from_s_ = std::min(target_from_s_, in_force_s_);
        if (!std::isfinite(steady_from_s_)) steady_from_s_ = in_force_s_ + transient_s;
    }

    [[nodiscard]] std::uint64_t newest() const noexcept { return sequence_; }
    /// Start of the awaited command; infinite while it is not in force.
    [[nodiscard]] double in_force_s() const noexcept { return in_force_s_; }
    /// Time at which the suspension has followed the newest large change; infinite while it has not started.
    [[nodiscard]] double steady_from_s() const noexcept { return steady_from_s_; }
    /// Start of the first command for the present target; infinite before it.
    [[nodiscard]] double target_from_s() const noexcept { return target_from_s_; }

private:
    double dac_rate_hz_;
    std::uint64_t sequence_ = 0, awaited_ = 0, target_sequence_ = 0;
    double in_force_s_ = 0, steady_from_s_ = 0, target_from_s_ = INFINITY;
};

inline constexpr double longest_soft_stop_s = 2;
inline constexpr double margin_periods = 2;   // driven after a measurement
inline constexpr double usable_drive = 0.95;  // share of the drive's limit; the rest is for corrections

struct RunPlan {
    control::ControllerSettings controller;
    double line_hz = 0;  // mains frequency, fitted together with the harmonics; 0: where it is found
    Task task{};
    int soft_start = 10;       // periods of the ramps at both ends
    int settle_at_most = 400;  // periods; then the measurement starts anyway, with a note
    int most_restarts = 3;     // after the DAC ran empty; then that is a trip
    double quiet_s = 0.6;      // length of the self-test at rest; at least one window
    safety::Limits limits;
    double gravity = paper_g;    // m/s^2 at the place
    bool gain_shown = true;      // as gain_shown() of run_setup.hpp
    double enable_before_s = 0;  // from the start of the enable output to the drive
    bool on_call = false;        // waits in idle for begin(), measures until end() and is never done()
    std::optional<PredictedWalk> walk{};  // not on call: noted before the drive starts
    std::vector<std::string> notes{};     // the first notes of the run; not on call
};

/// Length of a soft stop, s; frequency in Hz.
inline double soft_stop_s(const RunPlan& plan, double frequency) noexcept {
    return std::min(plan.soft_start / frequency, longest_soft_stop_s);
}

/// State machine over the gathered streams. It reads streams, posts drive commands and has no other effect.
/// Thread safety: one thread.
class Sequence {
public:
    using Say = std::function<void(const std::string&)>;
    Sequence(const RunPlan& plan, double dac_rate_hz, const AccelerometerInfo& accelerometer, Say say);

    /// Processes the data that arrived since the last call and posts a command when the drive should change.
    /// False when no data arrived.
    bool step(const acquisition::Streams& streams, acquisition::Channels& channels);
    /// InputError, which names `what`, unless a drive may start now: in idle, with no stop under way, and the
    /// walker is seen if a camera has it as a target.
    void require_idle(const char* what, const acquisition::Channels& channels) const;
    /// On call and in idle: drives towards `drive`, for `task`. An unknown response is identified first, a
    /// known one is checked at a low level. permit: for a walker beyond the edge limit. InputError in any
    /// other state.
    void begin(const Drive& drive, const Task& task, acquisition::Channels& channels,
               const std::optional<safety::EdgePermit>& permit = {});
    /// On call and in idle: whether measured harmonics correct the drive from the next begin() on. InputError
    /// in any other state.
    void close_loop(bool on);
    /// On call and in idle: identifies the response again, for this drive; then silence. InputError in any
    /// other state, and when the settings exclude identification.
    void identify(const Drive& drive, acquisition::Channels& channels);
    /// On call: a soft stop, then idle. A measurement under way keeps its whole periods. InputError when
    /// nothing is driven.
    void end(acquisition::Channels& channels);
    /// Not on call: ends the run, with a soft stop when something is driven.
    void leave(acquisition::Channels& channels);
    /// A new set-point in state run, for `task`: the drive changes over one period and settles. A measurement
    /// under way keeps its whole periods. InputError in any other state.
    void set(const Drive& drive, const Task& task, acquisition::Channels& channels);
    /// On call: ends the measurement under way, which keeps its whole periods, and measures no more at this
    /// set-point. The drive is kept. Without effect when nothing is measured.
    void hold();
    /// New limits for all guards, from now on.
    void hold_to(const safety::Limits& limits, acquisition::Channels& channels);
    /// Stops the run from outside: an immediate ramp to zero, which counts as a trip.
    void stop(acquisition::Channels& channels,
              const safety::Trip& why = {.cause = safety::Cause::operator_stop});
    /// The operator has acknowledged the trip: idle as soon as the output has unlatched, or the self-test
    /// again while it has not been passed. A later trip or abort keeps it latched. aborts: Channels::aborts
    /// when the operator cleared. InputError without a trip, while the drive is not silent yet, and while the
    /// contact of the abort input is not closed.
    void clear(std::uint64_t aborts, acquisition::Channels& channels);

    [[nodiscard]] const RunPlan& plan() const noexcept { return plan_; }
    [[nodiscard]] RunState state() const noexcept { return named(state_); }
    /// The run is over and the shaker silent.
    [[nodiscard]] bool done() const noexcept;
    /// The newest measurement that began: master time, s, a whole number of drive periods.
    [[nodiscard]] double from_s() const noexcept { return part_.from_s; }
    [[nodiscard]] double to_s() const noexcept { return part_.to_s; }
    /// In state run, with all measurements of the task finished (none for a move): the drive is only kept.
    [[nodiscard]] bool holding() const noexcept;
    /// Measurements until the drive is only kept; negative: no end. 0 outside state run.
    [[nodiscard]] int left() const noexcept;
    /// What the next measurement waits for, for the operator; empty outside state run and while one is under
    /// way.
    [[nodiscard]] std::string waits_for() const;
    /// set() is possible: in state run, and no edge permit is in use.
    [[nodiscard]] bool may_set() const noexcept {
        return state() == RunState::run && (!permit_ || permit_->over());
    }
    /// A measurement is under way.
    [[nodiscard]] bool measuring() const noexcept;
    /// Finished measurements since begin(), the newest last.
    [[nodiscard]] const std::vector<recording::FinishedMeasurement>& measured() const noexcept {
        return measured_;
    }
    /// leave() came before the measurement was complete.
    [[nodiscard]] bool interrupted() const noexcept { return leaving_ && measured_.empty(); }
    /// The measurement that leave() ended: to_s is the time of leave(). Empty: none had begun.
    [[nodiscard]] recording::MeasuredPart interrupted_part() const noexcept { return interrupted_part_; }
    /// Silent after a trip: clear() may follow.
    [[nodiscard]] bool may_clear() const noexcept;
    /// Master time played, and start of the present state, s.
    [[nodiscard]] double now_s() const noexcept { return now_s_; }
    [[nodiscard]] double since_s() const noexcept { return since_s_; }
    /// The newest window of the base's motion; empty before the first.
    [[nodiscard]] const std::optional<control::PeriodWindows::Window>& newest() const noexcept {
        return newest_;
    }
    [[nodiscard]] const control::PeriodWindows& windows() const noexcept { return windows_; }
    [[nodiscard]] const WalkerMonitor& walker() const noexcept { return walker_; }
    /// Distance from the edge of the picture at the first trip of a walker that has not been inside since,
    /// mm.
    [[nodiscard]] const std::optional<double>& edge_trip_mm() const noexcept { return edge_trip_mm_; }
    /// Remarks on the run for the reader of the results; on call: since begin().
    [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
    /// The note that degrades a measurement at a drive whose harmonics the mains hide; else empty.
    [[nodiscard]] std::string mains_doubt(const Drive& drive) const;
    /// Reason of the stop; empty when no limit stopped the drive.
    [[nodiscard]] const std::optional<safety::Trip>& trip() const noexcept { return trip_; }
    /// State of the run at a trip.
    struct Stop {
        RunState state;
        bool measuring;  // a measurement had begun and was not yet complete
    };
    /// One for each trip of the streams, in their order.
    [[nodiscard]] const std::vector<Stop>& stops() const noexcept { return stops_; }
    /// Index of trip() among the trips of the streams: the last one that did not come in state tripped.
    [[nodiscard]] std::size_t cause() const noexcept { return cause_; }
    [[nodiscard]] const control::DriveController& controller() const noexcept { return controller_; }

protected:
    /// Enters a state. When it may not follow the present one, the drive is stopped instead, with a note: a
    /// defect of the sequence must not leave the shaker without control.
    void go(const State& next, acquisition::Channels& channels);

private:
    void aim(const char* what, const Drive& drive, const acquisition::Channels& channels);
    void come_down(acquisition::Channels& channels);
    void take_trips(const acquisition::Streams& streams, acquisition::Channels& channels);
    void watch(const acquisition::Streams& streams, acquisition::Channels& channels);
    void check_walker(acquisition::Channels& channels);
    bool awaits_view(acquisition::Channels& channels);
    void note_failures(const std::vector<acquisition::CameraStream>& cameras);
    void take_stamps(const acquisition::Streams& streams, acquisition::Channels& channels);
    void start_again(std::int64_t lost, acquisition::Channels& channels);
    void arm(acquisition::Channels& channels);
    void take_accelerations(const acquisition::Streams& streams, acquisition::Channels& channels);
    void window_done(const control::PeriodWindows::Window& window, const acquisition::Streams& streams,
                     acquisition::Channels& channels);
    void take(const BaseFinding& finding, acquisition::Channels& channels);
    void identified(acquisition::Channels& channels);
    void report(const control::PeriodWindows::Window& window);
    void check_loop(bool resumes, acquisition::Channels& channels);
    void take_check(LoopCheck& check, const control::PeriodWindows::Window& window,
                    acquisition::Channels& channels);
    void start(acquisition::Channels& channels);
    void go_for_target(int ramp_periods, acquisition::Channels& channels);
    void begin_measuring(bool late);
    void keep_whole_periods();
    void finish_measuring(Run& run);
    [[nodiscard]] Run run_state(double from_s) const;
    void note_on_settling(bool late);
    bool fit_mains();
    void note_mains();
    void note(const std::string& what);
    void command(const Harmonics<Voltage>& volts, int ramp_periods, bool transient,
                 acquisition::Channels& channels);
    [[nodiscard]] bool stragglers_may_come();
    [[nodiscard]] bool walker_settled() const;

    // Goes on to the next state when the condition of the present one is fulfilled.
    void advance(Init& init, acquisition::Channels& channels);
    void advance(Quiet& quiet, acquisition::Channels& channels);
    void advance(Idle& /*idle*/, acquisition::Channels& /*channels*/) {}
    void advance(Armed& /*armed*/, acquisition::Channels& /*channels*/) {}
    void advance(Identify& /*identify*/, acquisition::Channels& /*channels*/) {}
    void advance(LoopCheck& check, acquisition::Channels& channels);
    void advance(Ramp& ramp, acquisition::Channels& channels);
    void advance(Run& run, acquisition::Channels& channels);
    void advance(RampDown& down, acquisition::Channels& channels);
    void advance(Tripped& tripped, acquisition::Channels& channels);
    void settle(Run& run);
    void finish_clearing(acquisition::Channels& channels);

    RunPlan plan_;
    bool leaving_ = false;
    recording::MeasuredPart interrupted_part_{0, 0};
    double dac_rate_hz_;
    double frequency_;  // realised by the synthesiser, Hz
    Say say_;
    control::PeriodWindows windows_;
    control::DriveController controller_;
    WalkerMonitor walker_;
    BaseMonitor base_;
    std::optional<safety::EdgePermit> permit_;  // of the present drive
    std::optional<double> edge_trip_mm_;
    Supervisor guard_;
    DriveInForce drive_;

    State state_;
    double since_s_ = 0;  // master time at which the state began
    /// The present order and its progress.
    struct Order {
        bool only_identify = false;   // silence follows the identification
        bool settling_noted = false;  // the notes on settling are written, for this set-point
        bool view_noted = false;      // the note on a change of the followed camera is written
        int restarts = 0;             // after the DAC ran empty
    } order_;
    static constexpr double aftermath_s = 0.3;  // recorded after a trip

    std::vector<bool> cameras_failed_;  // one for each camera, noted
    bool no_target_noted_ = false;      // no camera tracks a walker
    std::vector<Stop> stops_;           // one for each trip
    std::size_t cause_ = 0;             // index of the trip that stopped the run
    std::uint64_t newest_trip_ = 0;     // its number
    std::optional<safety::Trip> trip_;
    std::size_t plays_ = 0, blocks_ = 0, changes_ = 0;  // processed elements of the streams
    std::uint64_t underruns_ = 0;                       // of the DAC, in these
    AccelTick last_tick_{};                             // newest accelerometer sample
    bool clocks_known_ = false;                         // of DAC and accelerometer
    bool self_tested_ = false;                          // the self-test was passed
    double now_s_ = 0;                                  // master time played
    double reported_s_ = 0;                             // master time of the last reported window
    recording::MeasuredPart part_{0, 0};                // the newest measurement that began
    std::vector<recording::FinishedMeasurement> measured_;
    std::optional<control::PeriodWindows::Window> newest_;
    std::vector<std::string> notes_;
    std::string mains_;  // what was found of them; empty: nothing
};

}  // namespace shaker::run
