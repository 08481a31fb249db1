#pragma once
// Self-test: silence, harmonics 1 and 2 at a small voltage, silence. The findings show whether the bench is
// wired as its rig file says.
#include <array>
#include <cmath>
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/collector.hpp"
#include "daemon/acquisition/streams.hpp"
#include "drivers/handover.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker::run {

struct SelfTestPlan {
    double frequency = 20;     // Hz
    double volts = 0.02;       // peak of harmonic 1 and of harmonic 2 at the DAC, V
    double quiet_s = 1;        // silence before the drive, for the noise
    int ramp = 10;             // periods of the ramps at both ends
    int hold = 40;             // periods that are evaluated
    double gravity = paper_g;  // m/s^2 at the place
    /// Response by the data sheet at f, 2f, ..., m/s^2 per volt.
    std::array<std::complex<double>, max_harmonics> response{};
};

/// An interval of master time, s.
struct TimeSpan {
    double from_s = 0, to_s = 0;
};

/// Leads the self-test: posts the drive commands at their times.
class SelfTest {
public:
    SelfTest(const SelfTestPlan& plan, double dac_rate_hz);
    /// Processes new data. False when no data arrived. Throws DeviceError when the DAC ran empty.
    bool step(const acquisition::Streams& streams, Mailbox<DriveCommand>& drive);
    /// Ends it with a soft stop of the drive.
    void leave(Mailbox<DriveCommand>& drive);
    [[nodiscard]] bool done() const noexcept { return state_ == State::done; }
    /// A drive was begun.
    [[nodiscard]] bool drove() const noexcept { return sequence_ > 0; }
    /// The trip that stopped the self-test; empty: no limit stopped it.
    [[nodiscard]] const std::optional<safety::Trip>& trip() const noexcept { return trip_; }
    /// Intervals without a drive, and with the drive in force and the base settled.
    [[nodiscard]] TimeSpan quiet() const noexcept { return quiet_; }
    [[nodiscard]] TimeSpan held() const noexcept { return held_; }
    [[nodiscard]] const SelfTestPlan& plan() const noexcept { return plan_; }

private:
    enum class State { quiet, ramp, hold, ramp_down, tripped, done };
    void come_down(Mailbox<DriveCommand>& drive);
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

/// One result about a device. Its text includes what to check.
struct Finding {
    Verdict verdict = Verdict::good;
    std::string device;
    std::string text;
};

/// Findings of a finished self-test: rates, noise, clock fits, response, polarity, pictures, losses.
std::vector<Finding> judge(const SelfTest& test, const Rig& rig, acquisition::Collector& collector);

}  // namespace shaker::run
