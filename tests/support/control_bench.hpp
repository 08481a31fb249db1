#pragma once
// A shaker in closed loop without anything above the control: synthesiser, plant, sensor, estimator and a law
// that says what to play next. What the base really did is judged without the sensor.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/drive_keeper.hpp"
#include "drivers/simulated/shaker_plant.hpp"

namespace shaker::test {

/// What a law is told when it begins.
struct Known {
    Drive drive;
    IdentifiedResponse response;
    std::function<std::complex<double>(double)> sheet;  // of the shaker, at a frequency
    double volts_limit = 1;
    double noise = 0;  // m/s^2, sd of an amplitude's part in a window
};

/// A way to close the loop: hears of each window and may change what is played.
class DriveLaw {
public:
    virtual ~DriveLaw() = default;
    virtual const Harmonics<Voltage>& volts() = 0;
    /// newest: the drive given last was in force. True when volts() changed.
    virtual bool take(const MotionWindows::Window& window, bool newest) = 0;
    virtual void set(const Drive& drive) = 0;
    /// The law has stopped the drive.
    virtual bool gave_up() { return false; }
    virtual double reached() { return 1; }
};
using MakeLaw = std::function<std::unique_ptr<DriveLaw>(const Known& known)>;

MakeLaw hybrid();                     // ours
MakeLaw integral(double share);       // U += share (R - Y) / H, every window
MakeLaw time_waveform(double share);  // U += share (R - Y) / H, on settled windows

/// What happens in a run, at a period after the drive has begun.
struct ControlEvent {
    int period = 0;
    std::function<void(ShakerPlant&)> plant{};  // may be empty
    std::optional<Drive> drive{};               // a new set-point
    double sensor_sign = 1;                     // from then on
};

struct ControlCase {
    std::string name{};
    Scene scene{};
    Drive drive{};
    int periods = 600;
    int latency = 2;                     // periods between a window's end and the drive that follows from it
    std::complex<double> misjudged = 1;  // the law gets this times the identified response
    bool identify = true;                // false: it gets the data sheet's
    double volts_limit = 1;
    double mains_hz = 0;
    int dac_bits = 0;      // 0: exact; else rounded with triangular dither
    int lock_within = 60;  // periods: what shakerd must reach; 0: it cannot lock, and must say why
    double mean_db = -80;  // and what the mean of 100 periods must stay below
    std::vector<ControlEvent> events{};
    int judged_from = 0;  // period from which locking counts
};

/// The plants, mistakes, changes and limits that are tried, by name.
std::vector<ControlCase> control_cases();

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
