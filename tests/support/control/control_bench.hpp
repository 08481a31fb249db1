#pragma once
// A shaker in closed loop: synthesiser, plant, sensor, estimator and a control law. The results are computed
// from the true motion of the base, not from the sensor.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/control/drive_controller.hpp"
#include "drivers/simulated/shaker_plant.hpp"

namespace shaker::test {

/// Inputs of a law at the start.
struct Known {
    Drive drive;
    control::IdentifiedResponse response;
    std::function<std::complex<double>(double)> sheet;  // of the shaker, at a frequency
    double volts_limit = 1;
    double noise = 0;  // m/s^2, sd of one component of an amplitude in a window
};

/// A control law: receives each window and may change the drive.
class DriveLaw {
public:
    virtual ~DriveLaw() = default;
    virtual const Harmonics<Voltage>& volts() = 0;
    /// newest: the window was measured with the newest drive. Returns true if volts() changed.
    virtual bool take(const control::PeriodWindows::Window& window, bool newest) = 0;
    virtual void set(const Drive& drive) = 0;
    /// True if the law has stopped the drive.
    virtual bool gave_up() { return false; }
    virtual double reached() { return 1; }
};
using MakeLaw = std::function<std::unique_ptr<DriveLaw>(const Known& known)>;

MakeLaw hybrid();                     // ours
MakeLaw integral(double share);       // U += share (R - Y) / H, every window
MakeLaw time_waveform(double share);  // U += share (R - Y) / H, on settled windows

/// An event in a run, at a period after the start of the drive.
struct ControlEvent {
    int period = 0;
    std::function<void(simulated::ShakerPlant&)> plant{};  // may be empty
    std::optional<Drive> drive{};                          // a new set-point
    double sensor_sign = 1;                                // from then on
};

struct ControlCase {
    std::string name{};
    simulated::Scene scene{};
    Drive drive{};
    int periods = 600;
    int latency = 2;                     // periods from the end of a window to the drive computed from it
    std::complex<double> misjudged = 1;  // factor on the identified response that the law gets
    bool identify = true;                // false: the law gets the response of the data sheet
    double volts_limit = 1;
    double mains_hz = 0;
    int dac_bits = 0;      // 0: exact; else rounded with triangular dither
    int lock_within = 60;  // periods; 0: it cannot lock and must report the reason
    double mean_db = -80;  // limit for the mean of 100 periods
    std::vector<ControlEvent> events{};
    int judged_from = 0;  // period from which locking counts
};

/// All cases by name: plants, errors of the model, changes, limits.
std::vector<ControlCase> control_cases();

struct ControlResult {
    int lock60 = -1, lock80 = -1;  // periods after judged_from until it stays locked; -1: never
    double mean_db = 0;            // worst harmonic 1..8 of the last 100 periods' mean, re gamma
    double rms_db = 0;             // the same, rms of single periods
    double tail_db = 0;            // harmonics 9..16 together
    double delta_mrad = 0;         // error of phi in the last 100 periods' mean
    double reached = 1;
    bool gave_up = false;
    control::IdentifiedResponse response;
};

ControlResult run_control(const ControlCase& c, const MakeLaw& make, std::uint64_t seed);

}  // namespace shaker::test
