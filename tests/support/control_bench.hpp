#pragma once
// A shaker in closed loop without anything above the control: synthesiser, plant, sensor, estimator and a law
// that says what to play next. What the base really did is judged without the sensor.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/control/equaliser.hpp"
#include "daemon/control/identification.hpp"
#include "daemon/motion_windows.hpp"
#include "drivers/simulated/shaker_plant.hpp"

namespace shaker::test {

/// A way to close the loop: hears of each window and may change what is played.
class DriveLaw {
public:
    virtual ~DriveLaw() = default;
    virtual const Harmonics<Voltage>& volts() = 0;
    /// True when volts() changed.
    virtual bool take(const MotionWindow& window) = 0;
    virtual void retarget(const Harmonics<Acceleration>& target) = 0;
    /// The law has stopped the drive.
    virtual bool gave_up() { return false; }
    virtual double reached() { return 1; }
};
using MakeLaw = std::function<std::unique_ptr<DriveLaw>(
    const Harmonics<Acceleration>& target, const std::array<std::complex<double>, max_harmonics>& response,
    const EqualiserSettings& settings)>;

MakeLaw hybrid();                     // ours
MakeLaw integral(double share);       // U += share (R - Y) / H, every window
MakeLaw time_waveform(double share);  // U += share (R - Y) / H, on settled windows

/// What happens in a run, at a period after the drive has begun.
struct ControlEvent {
    int period = 0;
    std::function<void(ShakerPlant&)> plant{};  // may be empty
    std::optional<Drive> drive{};               // a new set-point
};

struct ControlCase {
    std::string name;
    Scene scene;
    Drive drive{};
    int periods = 600;
    int latency = 2;                     // periods between a window's end and the drive that follows from it
    std::complex<double> misjudged = 1;  // the law gets this times the identified response
    double sensor_sign = 1;
    double volts_limit = 1;
    std::vector<ControlEvent> events{};
    int judged_from = 0;  // period from which locking counts
};

struct ControlResult {
    int lock60 = -1, lock80 = -1;  // periods after judged_from until it holds to the end; -1: never
    double mean_db = 0;            // worst harmonic 1..8 of the last 100 periods' mean, re gamma
    double rms_db = 0;             // the same, rms of single periods
    double tail_db = 0;            // harmonics 9..16 together
    double delta_mrad = 0;         // error of phi in the last 100 periods' mean
    double reached = 1;
    bool gave_up = false;
    IdentifiedResponse response;
};

ControlResult run_control(const ControlCase& c, const MakeLaw& make, std::uint64_t seed);

}  // namespace shaker::test
