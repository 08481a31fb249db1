#pragma once
// The safety that needs more than samples: windows of the base, the walker's place, the cameras. And what the
// guard of the samples is told to expect.
#include <optional>

#include "daemon/acquisition/channels.hpp"
#include "daemon/control/drive_controller.hpp"
#include "daemon/control/period_windows.hpp"
#include "daemon/run/state.hpp"
#include "daemon/run/walker_monitor.hpp"
#include "daemon/safety/clock_guard.hpp"
#include "daemon/safety/period_guard.hpp"

namespace shaker::run {

class Supervisor {
public:
    /// gravity: of the place, m/s^2.
    Supervisor(const safety::Limits& limits, const AccelerometerInfo& accelerometer, double dac_rate_hz,
               double gravity)
        : limits_{limits},
          accelerometer_{accelerometer},
          dac_rate_hz_{dac_rate_hz},
          gravity_{gravity},
          loop_{limits},
          clocks_{accelerometer.rate_hz} {}

    /// A window without a drive: the sensor must show the gravity of the place, or none.
    void look_at_rest(const control::PeriodWindows::Window& window, acquisition::Channels& channels);
    /// How a window stands to the target: that was gone for all through it; and the keeper's equaliser has
    /// had the window.
    struct Standing {
        bool current = false, followed = false;
    };
    /// A window in a state with a drive. Orders a stop when something is wrong, else tells the guard of the
    /// samples what this drive makes of the base once that no longer changes.
    void look(const control::PeriodWindows::Window& window, const control::DriveController& controller,
              Standing standing, const calibration::Timebase& timebase, AccelTick tick,
              acquisition::Channels& channels);
    /// What was found out of the response, at the end or at one of its levels.
    void look(const control::IdentifiedResponse& response, bool ended, double now_s,
              acquisition::Channels& channels);
    /// The walker, while the base is driven.
    void look(const WalkerMonitor& walker, double now_s, acquisition::Channels& channels);
    /// The cameras, while the base is driven.
    void look(const std::vector<acquisition::CameraStream>& cameras, double now_s,
              acquisition::Channels& channels);
    /// Another target, or a drive that comes up anew, was ordered.
    void settling() noexcept { loop_.settling(); }
    /// Before another target is gone for: what the base makes of it is known less well than what it makes of
    /// the present one, until a window has shown it.
    void expect_another(acquisition::Channels& channels);
    /// The DAC ran empty: the clocks as they were known tell nothing any more.
    void clocks_lost() noexcept { posted_.reset(); }
    /// Other levels from now on.
    void hold_to(const safety::Limits& limits) noexcept {
        limits_ = limits;
        loop_.hold_to(limits);
    }
    /// After a trip: look afresh.
    void rearm() noexcept { ordered_ = false, loop_.settling(), clocks_.reset(), posted_.reset(); }

private:
    void order(const safety::Trip& trip, acquisition::Channels& channels);
    void found(safety::Cause cause, double value, double limit, double now_s,
               acquisition::Channels& channels);
    [[nodiscard]] std::int64_t tick_at(double now_s) const {
        return static_cast<std::int64_t>(now_s * dac_rate_hz_);
    }
    /// target: what the drive is corrected towards; empty when it is not.
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
    Harmonics<Acceleration> before_;  // as the last window showed it
    bool ordered_ = false;            // a stop, which will come back as a trip
};

}  // namespace shaker::run
