#pragma once
// A short low-level drive that tells whether a bench is wired as its rig file says: silence, both harmonics
// at a small voltage, silence.
#include <array>
#include <cmath>
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "drivers/handover.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker::run {

struct SelfTestPlan {
    double frequency = 20;     // Hz
    double volts = 0.02;       // of each of harmonics 1 and 2, at the DAC
    double quiet_s = 1;        // of silence before, for the noise
    int ramp = 10;             // periods of the ramps at both ends
    int hold = 40;             // periods that are judged
    double gravity = paper_g;  // m/s^2 at the place
    /// Data sheet, m/s^2 a volt at f, 2f, ...
    std::array<std::complex<double>, max_harmonics> response{};
};

/// A part of master time, s.
struct TimeSpan {
    double from_s = 0, to_s = 0;
};

/// Leads the self-test: posts the drive when its time has come.
class SelfTest {
public:
    SelfTest(const SelfTestPlan& plan, double dac_rate_hz);
    /// False when nothing had come. Throws DeviceError when the DAC ran empty: what was asked of it is gone
    /// then.
    bool step(const acquisition::Streams& streams, Mailbox<DriveCommand>& drive);
    [[nodiscard]] bool done() const noexcept { return state_ == State::done; }
    /// Why a limit stopped it; empty: none did.
    [[nodiscard]] const std::optional<safety::Trip>& trip() const noexcept { return trip_; }
    /// Without a drive, and with the drive in force and the base settled.
    [[nodiscard]] TimeSpan quiet() const noexcept { return quiet_; }
    [[nodiscard]] TimeSpan held() const noexcept { return held_; }
    [[nodiscard]] const SelfTestPlan& plan() const noexcept { return plan_; }

private:
    enum class State { quiet, ramp, hold, ramp_down, tripped, done };
    void post(const Harmonics<Voltage>& volts, Mailbox<DriveCommand>& drive);

    SelfTestPlan plan_;
    double dac_rate_hz_;
    State state_ = State::quiet;
    std::size_t plays_ = 0, changes_ = 0;
    std::uint64_t sequence_ = 0;
    double in_force_s_ = 0;
    std::optional<safety::Trip> trip_;
    double silent_s_ = INFINITY;  // end of the ramp to zero after a trip
    TimeSpan quiet_, held_;
};

enum class Verdict { good, warning, bad };

/// One thing that was found out about a device, in words an operator can act on.
struct Finding {
    Verdict verdict = Verdict::good;
    std::string device;
    std::string text;
};

/// What a finished self-test says: rates, noise, clock fits, response, polarity, pictures, losses.
std::vector<Finding> judge(const SelfTest& test, const Rig& rig, acquisition::Streams& streams);

}  // namespace shaker::run
