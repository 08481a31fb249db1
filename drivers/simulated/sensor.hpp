#pragma once
// The simulated accelerometer's inside: low-pass, own clock, noise, quantisation, blocks.
#include <optional>
#include <random>

#include "drivers/devices.hpp"
#include "drivers/simulated/scene.hpp"

namespace shaker {

class AccelerometerModel {
public:
    explicit AccelerometerModel(const Scene& scene);
    [[nodiscard]] AccelerometerInfo info() const;
    /// The base's acceleration at DAC sample n (true time n / DAC rate). Returns a block when one has filled
    /// up or samples are missing behind it; its `arrived` is when the host gets it.
    std::optional<AccelBlock> step(std::int64_t n, double a_base);

private:
    [[nodiscard]] double low_passed(double a) noexcept;
    [[nodiscard]] std::array<std::int32_t, 3> converted(double a_base, double t, Quality& quality);
    [[nodiscard]] bool loses(double t) noexcept;
    [[nodiscard]] AccelBlock handed_on();

    AccelerometerTruth p_;
    double dac_rate_;
    double gravity_, downhill_;
    double lsb_;
    std::array<double, 3> axis_{};  // shaker's axis in sensor axes
    std::array<double, 5> biquad_{};
    std::array<double, 2> memory_{};
    double before_ = 0;      // filtered acceleration one DAC sample ago
    double start_s_;         // true time of tick 0
    std::int64_t next_ = 0;  // tick of the next conversion
    AccelBlock block_{};     // being filled
    double filled_s_ = 0;    // true time of its last sample
    bool gap_ = false;       // samples are missing before the next one
    std::array<std::int32_t, 3> last_{};
    LastingFaults faults_;
    FaultQueue drops_;
    std::int64_t dropped_until_ = 0;  // tick
    std::mt19937_64 rng_;
    std::normal_distribution<double> noise_;
    std::exponential_distribution<double> jitter_;
};

/// Virtual host time of a true time in seconds since DAC sample 0.
HostTime host_time(double true_s) noexcept;

}  // namespace shaker
