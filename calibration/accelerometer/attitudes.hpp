#pragma once
// The attitudes in which an accelerometer is held at rest, from its samples.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/attitude.hpp"

namespace shaker::calibration {

using Vector = std::array<double, 3>;

/// Attitudes farther apart are different ones; also the largest angle between an attitude and its name, rad.
inline constexpr double same_attitude = 0.349;  // 20 deg; neighbours among the 18 are 45 deg apart

using Counts = std::array<std::int32_t, 3>;

/// What one held record says, for each axis. The record is cut into 10 parts, each of 5 pieces.
struct Attitude {
    std::string name{};  // as in direction_of(); empty: not known
    Vector mean{};       // counts
    Vector variance{};   // of the means of the parts, counts^2; 9 degrees of freedom
    Vector expected{};   // the same from the scatter of the pieces within their parts; 40 degrees of freedom
};

/// Fewest samples of a record.
inline constexpr std::size_t fewest_samples = 100;

/// Throws InputError for a record with fewer than fewest_samples.
Attitude attitude_of(std::string name, std::span<const Counts> samples);

/// Reason why the sensor was not at rest, as a clause; empty if it was. counts_per_g: one g in counts on each
/// axis. A record is refused if the means of its parts scatter more than its quick noise explains (F test,
/// 1e-6) and by more than 5e-5 g.
std::string motion_in(const Attitude& attitude, const Vector& counts_per_g);

/// "attitude 3 (+y)"
std::string label_of(std::size_t index, const Attitude& attitude);

/// The standard attitude nearest to a direction of up.
std::string_view nearest_attitude(const Vector& direction) noexcept;
/// Standard attitudes that none of these directions is near.
std::vector<std::string_view> missing_attitudes(std::span<const Vector> directions);

/// Finds in a stream of samples the attitudes in which a sensor is held at rest. An attitude is found when
/// the sensor was at rest (motion_in()) for the hold time, farther than same_attitude from the one found
/// before. The one at the start does not count: it is where the sensor lay.
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
