#pragma once
// AccelerometerModel: low-pass, clock, noise, quantisation and blocks of the simulated accelerometer.
#include <array>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/simulated/scene.hpp"

namespace shaker::simulated {

/// The words of a text.
std::vector<std::string> words_of(const std::string& text);

/// An accelerometer off the base that is held in one attitude after the other. Lies with z up for hold_s,
/// then is turned for turn_s and held for hold_s in each attitude of the scene; stays in the last one.
class TurnedSensor {
public:
    explicit TurnedSensor(const Scene& scene);
    /// True if the scene has attitudes.
    [[nodiscard]] bool turned() const noexcept { return up_.size() > 1; }
    /// Specific force in the sensor's axes at true time t, m/s^2.
    [[nodiscard]] std::array<double, 3> force(double t) const noexcept;

private:
    double hold_s_, turn_s_, gravity_;
    std::vector<std::array<double, 3>> up_;  // unit vectors, with the errors of the hand
};

/// Reading: specific force, gravity included. Frame: z up, x along the shaker's axis rotated by -yaw about z.
/// On a base tilted by b: u (a_B - g sin b) + z g cos b, with u = (cos yaw, -sin yaw, 0) and +x downhill for
/// b > 0. At rest on a level base the sensor reads +g on z. A scene with attitudes takes the sensor off the
/// base. A high-pass acts on the motion along x; the scene may have fewer axes, and no gravity in the
/// reading.
class AccelerometerModel {
public:
    explicit AccelerometerModel(const Scene& scene);
    [[nodiscard]] AccelerometerInfo info() const;
    /// Advances to DAC sample n (true time n / DAC rate). a_base: the base's acceleration, m/s^2, its mean
    /// over the step that ends there: a walker that begins to slip within the step counts as long as it
    /// slips. Returns a block when it is full or samples are missing after it; `arrived` is its arrival at
    /// the host.
    std::optional<AccelBlock> step(std::int64_t n, double a_base);

private:
    [[nodiscard]] double low_passed(double a) noexcept;
    [[nodiscard]] double high_passed(double a) noexcept;
    [[nodiscard]] std::array<std::int32_t, 3> converted(double a_base, double t, Quality& quality);
    [[nodiscard]] std::array<std::int32_t, 3> delivered(double t) noexcept;
    void advance_clock();
    [[nodiscard]] bool loses(double t) noexcept;
    [[nodiscard]] AccelBlock handed_on();

    AccelerometerTruth p_;
    double dac_rate_;
    double gravity_, downhill_;
    TurnedSensor turned_;
    double lsb_;
    std::array<double, 3> axis_{};  // shaker's axis in sensor axes
    std::array<double, 5> biquad_{};
    std::array<double, 2> memory_{};
    double high_pass_keep_;  // factor of a pole's output per DAC sample
    struct Pole {
        double in = 0, out = 0;
    };
    std::array<Pole, 2> poles_{};
    double before_ = 0;      // filtered acceleration one DAC sample ago
    double start_s_;         // true time of tick 0
    std::int64_t next_ = 0;  // tick of the next conversion
    double ahead_s_ = 0;     // its clock is ahead of one with a constant rate
    AccelBlock block_{};     // being filled
    double filled_s_ = 0;    // true time of its last sample
    bool gap_ = false;       // samples are missing before the next one
    std::array<std::int32_t, 3> last_{};
    LastingFaults faults_;
    FaultQueue drops_, bad_samples_;
    std::int64_t dropped_until_ = 0;  // tick
    std::mt19937_64 rng_;
    std::normal_distribution<double> noise_;
    std::mt19937_64 clock_rng_;
    std::normal_distribution<double> clock_step_;
    std::exponential_distribution<double> jitter_;
};

/// Virtual host time of a true time in seconds since DAC sample 0.
HostTime host_time(double true_s) noexcept;

}  // namespace shaker::simulated
