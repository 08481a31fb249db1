#pragma once
// HeldFinder: finds in a stream of samples the attitudes in which a sensor is held at rest.
#include <optional>
#include <span>
#include <vector>

#include "calibration/accelerometer/attitudes.hpp"

namespace shaker::calibration {

/// An attitude is found when the sensor was at rest (motion_in()) for the hold time, farther than
/// same_attitude from the one found before. The one at the start does not count: it is where the sensor lay.
class HeldFinder {
public:
    /// nominal: m/s^2 per count of each axis.
    HeldFinder(double rate_hz, double hold_s, const Vector& nominal, double gravity);

    /// The next sample. An attitude, without a name, when this sample completes one.
    [[nodiscard]] std::optional<Attitude> add(const Counts& sample);
    /// Samples are missing or saturated before the next one.
    void begin_again() noexcept { record_.clear(); }
    /// Samples of the attitude found last.
    [[nodiscard]] std::span<const Counts> record() const noexcept { return found_; }
    /// Why the newest samples are no attitude, as a clause.
    [[nodiscard]] const std::string& why_not() const noexcept { return why_not_; }

private:
    [[nodiscard]] bool turned_to(const Vector& mean);

    Vector nominal_, counts_per_g_{};
    std::size_t size_;  // samples of a record
    std::vector<Counts> record_, found_;
    std::optional<Vector> before_{};  // direction of the attitude found before
    std::string why_not_;
};

}  // namespace shaker::calibration
