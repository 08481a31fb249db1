#pragma once
// What the record of an accelerometer that is held in one attitude says.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/attitude/attitude.hpp"

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

}  // namespace shaker::calibration
