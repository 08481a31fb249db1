#pragma once
// The safety that needs more than samples: windows of the base, the walker's place, the cameras. And what the
// guard of the samples is told to expect.
#include <optional>

#include "daemon/clock_watch.hpp"
#include "daemon/control/loop_guard.hpp"
#include "daemon/drive_keeper.hpp"
#include "daemon/lanes.hpp"
#include "daemon/motion_windows.hpp"
#include "daemon/run_states.hpp"
#include "daemon/walker_watch.hpp"

namespace shaker {

class RunGuard {
public:
    RunGuard(const Limits& limits, const AccelerometerInfo& accelerometer, double dac_rate_hz)
        : limits_{limits},
          accelerometer_{accelerometer},
          dac_rate_hz_{dac_rate_hz},
          loop_{limits},
          clocks_{accelerometer.rate_hz} {}

    /// A window without a drive: of the earth's gravity the sensor must show what it should, or nothing.
    void look_at_rest(const MotionWindows::Window& window, Lanes& lanes);
    /// How a window stands to the target: that was gone for all through it; and the keeper's equaliser has
    /// had the window.
    struct Standing {
        bool current = false, followed = false;
    };
    /// A window in a state with a drive. Orders a stop when something is wrong, else tells the guard of the
    /// samples what this drive makes of the base once that no longer changes.
    void look(const MotionWindows::Window& window, const DriveKeeper& keeper, Standing standing,
              const DriveClock& clock, AccelTick tick, Lanes& lanes);
    /// What was found out of the response, at the end or at one of its levels.
    void look(const IdentifiedResponse& response, bool ended, double now_s, Lanes& lanes);
    /// The walker, while the base is driven.
    void look(const WalkerWatch& walker, double now_s, Lanes& lanes);
    /// The cameras, while the base is driven.
    void look(const std::vector<CameraTake>& cameras, double now_s, Lanes& lanes);
    /// Another target, or a drive that comes up anew, was ordered.
    void settling() noexcept { loop_.settling(); }
    /// Before another target is gone for: what the base makes of it is known less well than what it makes of
    /// the present one, until a window has shown it.
    void expect_another(Lanes& lanes);
    /// The DAC ran empty: the clocks as they were known tell nothing any more.
    void clocks_lost() noexcept { posted_.reset(); }
    /// Other levels from now on.
    void hold_to(const Limits& limits) noexcept {
        limits_ = limits;
        loop_.hold_to(limits);
    }
    /// After a trip: look afresh.
    void rearm() noexcept { ordered_ = false, loop_.settling(), clocks_.reset(), posted_.reset(); }

private:
    void order(const Trip& trip, Lanes& lanes);
    void found(Cause cause, double value, double limit, double now_s, Lanes& lanes);
    [[nodiscard]] std::int64_t tick_at(double now_s) const {
        return static_cast<std::int64_t>(now_s * dac_rate_hz_);
    }
    /// target: what the drive is corrected towards; empty when it is not.
    [[nodiscard]] Expectation expectation(const MotionWindows::Window& window,
                                          const Harmonics<Acceleration>& target, const DriveKeeper& keeper,
                                          const DriveClock& clock, AccelTick tick, Warnings& warnings);

    Limits limits_;
    AccelerometerInfo accelerometer_;
    double dac_rate_hz_;
    LoopGuard loop_;
    ClockWatch clocks_;
    std::optional<Expectation> posted_;
    Harmonics<Acceleration> before_;  // as the last window showed it
    bool ordered_ = false;            // a stop, which will come back as a trip
};

}  // namespace shaker
