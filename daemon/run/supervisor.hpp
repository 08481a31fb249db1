#pragma once
// Safety checks that need more than samples: windows of the base's motion, the walker's place, the cameras.
// Also computes the expectation for the sample guard.
#include <optional>

#include "daemon/acquisition/channels.hpp"
#include "daemon/control/drive_controller.hpp"
#include "daemon/control/period_windows.hpp"
#include "daemon/run/state.hpp"
#include "daemon/run/walker_monitor.hpp"
#include "daemon/safety/period_guard.hpp"

namespace shaker::run {

class Supervisor {
public:
    /// gravity: at the place, m/s^2.
    Supervisor(const safety::Limits& limits, const AccelerometerInfo& accelerometer, double dac_rate_hz,
               double gravity)
        : limits_{limits},
          accelerometer_{accelerometer},
          dac_rate_hz_{dac_rate_hz},
          gravity_{gravity},
          loop_{limits},
          clocks_{accelerometer.rate_hz} {}

    /// Checks a window without a drive: the sensor must measure the gravity of the place or no constant part;
    /// the constant part of one without gravity must have settled, for at most a minute. True: it does.
    /// False: it does not, and a stop is ordered.
    bool check_at_rest(const control::PeriodWindows::Window& window, acquisition::Channels& channels);
    /// Relation of a window to the target.
    struct Standing {
        bool current = false;   // the target was in force during the whole window
        bool followed = false;  // and the equaliser corrects towards it
    };
    /// Checks a window in a state with a drive. Orders a stop when a check fails. Otherwise it posts the
    /// expected motion to the sample guard as soon as the motion is constant.
    void check(const control::PeriodWindows::Window& window, const control::DriveController& controller,
               Standing standing, const calibration::Timebase& timebase, AccelTick tick,
               acquisition::Channels& channels);
    /// Checks an identified response. ended: after the last level; false: after one of the levels.
    void check(const control::IdentifiedResponse& response, bool ended, double now_s,
               acquisition::Channels& channels);
    /// Checks the walker's place and tracking while the base is driven.
    void check(const WalkerMonitor& walker, double now_s, acquisition::Channels& channels);
    /// Checks that a camera sends pictures of the walker. False: none does, and a stop is ordered.
    bool check_view(const WalkerMonitor& walker, double now_s, acquisition::Channels& channels);
    /// Orders this stop; false when the detector of its cause is off.
    bool stop(safety::Trip trip, double now_s, acquisition::Channels& channels);
    /// A stop is ordered and not excused.
    [[nodiscard]] bool ordered() const noexcept { return ordered_; }
    /// Call it when another target or a restart of the drive was ordered.
    void settling() noexcept { loop_.settling(); }
    /// Call it before another target. Widens the expectation's tolerance, because the response at the
    /// new target is less well known until a window has measured it.
    void expect_another(acquisition::Channels& channels);
    /// A loop check begins or has ended. Between both the sample guard checks levels only, because the check
    /// measures whether the bench still moves as expected.
    void loop_check(bool begins, acquisition::Channels& channels);
    /// Call it after the DAC ran empty: the relation of the clocks is no longer known.
    void clocks_lost() noexcept { posted_.reset(); }
    /// New limits from now on.
    void hold_to(const safety::Limits& limits) noexcept {
        limits_ = limits;
        loop_.hold_to(limits);
    }
    /// Starts again after a trip.
    void rearm() noexcept {
        ordered_ = false, loop_.settling(), clocks_.reset(), posted_.reset();
        rest_from_s_ = rest_s_ = NAN, settles_.reset();
    }
    /// The constant part of a sensor without gravity still changes.
    [[nodiscard]] bool settles() const noexcept { return settles_ == true; }

private:
    void order(const safety::Trip& trip, acquisition::Channels& channels);
    bool settled(const control::PeriodWindows::Window& window) noexcept;
    [[nodiscard]] std::int64_t tick_at(double now_s) const {
        return static_cast<std::int64_t>(now_s * dac_rate_hz_);
    }
    /// target: motion towards which the drive is corrected; zero in an open loop.
    [[nodiscard]] safety::Expectation expectation(const control::PeriodWindows::Window& window,
                                                  const Harmonics<Acceleration>& target,
                                                  const control::DriveController& controller,
                                                  const calibration::Timebase& timebase, AccelTick tick,
                                                  safety::Warnings& warnings);

    safety::Limits limits_;
    AccelerometerInfo accelerometer_;
    double dac_rate_hz_;
    double gravity_;
    safety::PeriodGuard loop_;
    safety::ClockGuard clocks_;
    std::optional<safety::Expectation> posted_;
    Harmonics<Acceleration> before_;           // motion in the previous window
    std::array<double, 3> rest_{};             // constant part in an earlier window at rest, m/s^2 ...
    double rest_s_ = NAN, rest_from_s_ = NAN;  // ... and its time; time of the first window, s
    std::optional<bool> settles_{};            // empty: not compared yet
    bool ordered_ = false;       // a stop is ordered; the output reports it as a trip, or excuses it
    std::uint64_t excused_ = 0;  // Channels::excused at that time
};

}  // namespace shaker::run
