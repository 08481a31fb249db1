#pragma once
// Leads one run: soft start, settling with the measured harmonics correcting the drive, measuring, soft stop.
#include <array>
#include <complex>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/control/equaliser.hpp"
#include "daemon/control/harmonic_estimator.hpp"
#include "daemon/drive_clock.hpp"
#include "daemon/reduction/period_fold.hpp"
#include "daemon/take.hpp"
#include "drivers/handover.hpp"

namespace shaker {

struct RunPlan {
    Drive drive;
    int periods = 40;          // to measure
    int soft_start = 10;       // periods of the ramps at both ends
    int settle_at_most = 400;  // periods; then it measures all the same and says so
    int most_restarts = 3;     // after the DAC ran empty; then the run fails
    double volts_limit = 1;    // of the DAC
    std::array<std::complex<double>, max_harmonics> response{};  // m/s^2 a volt at f, 2f, ...
};

enum class RunState { ramp, settle, measure, ramp_down, done };

/// A state machine over what has been gathered. It reads the take and answers with drive commands: nothing
/// else.
class Director {
public:
    using Say = std::function<void(const std::string&)>;
    Director(const RunPlan& plan, double dac_rate_hz, const AccelerometerInfo& accelerometer, Say say);

    /// Looks at what came since the last call and posts a command when the drive should change. False when
    /// nothing had come.
    bool step(const Take& take, Mailbox<DriveCommand>& drive);
    [[nodiscard]] RunState state() const noexcept { return state_; }
    /// Part of master time that was measured, s; whole periods of the drive.
    [[nodiscard]] double from_s() const noexcept { return from_s_; }
    [[nodiscard]] double to_s() const noexcept { return to_s_; }
    /// What a reader of the results should know of how the run went.
    [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

private:
    void take_stamps(const Take& take, Mailbox<DriveCommand>& drive);
    void start_again(std::int64_t lost, Mailbox<DriveCommand>& drive);
    void watch(const AccelBlock& block);
    void take_accelerations(const Take& take, Mailbox<DriveCommand>& drive);
    void take_tracks(const Take& take);
    void period_done(const PeriodEstimate& estimate, Mailbox<DriveCommand>& drive);
    void correct(const PeriodEstimate& estimate, Mailbox<DriveCommand>& drive);
    void note(const std::string& what);
    void advance(Mailbox<DriveCommand>& drive);
    void command(const Harmonics<Voltage>& volts, int ramp_periods, Mailbox<DriveCommand>& drive);
    [[nodiscard]] bool stragglers_may_come();
    [[nodiscard]] bool settled_since_steady() const;

    RunPlan plan_;
    double frequency_;  // as it is really played, Hz
    double dac_rate_hz_;
    AccelerometerInfo accelerometer_;
    Say say_;
    DriveClock clock_;
    HarmonicEstimator estimator_;
    Equaliser equaliser_;
    PeriodFold fold_;
    RunState state_ = RunState::ramp;
    std::size_t plays_ = 0, blocks_ = 0, changes_ = 0, tracks_ = 0;  // how much of the take has been seen
    std::uint64_t sequence_ = 0;
    int restarts_ = 0;
    std::array<std::int32_t, 3> last_counts_{};  // of the accelerometer
    int repeats_ = 0;                            // of the last sample
    bool started_ = false, locked_ = false, watches_walker_ = false, walker_settled_ = false;
    double now_s_ = 0;          // master time played
    double told_s_ = 0;         // of the period that was told last
    double steady_from_s_ = 0;  // the newest change of the drive has been in effect since
    double settle_from_s_ = 0;
    double from_s_ = 0, to_s_ = 0, silent_s_ = 0;
    double accelerations_until_s_ = 0, tracks_until_s_ = 0;  // of what has come
    double reached_ = 1;  // share of the asked gamma that the voltage limit lets through
    std::vector<PeriodFold::Period> drifts_;
    std::vector<std::string> notes_;
};

}  // namespace shaker
