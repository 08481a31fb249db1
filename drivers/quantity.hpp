#pragma once
// Parses quantities with units as typed by a person: "1.5g", "14.7 m/s^2", "35deg", "0.61rad", "20Hz",
// "50ms".
#include <string>
#include <string_view>

namespace shaker {

enum class Dimension { acceleration, angle, frequency, time, velocity, length, ratio };

/// Closed interval; an end may be infinite.
struct Range {
    double min;
    double max;
};

/// The shortest text that reads back as the same number, in any locale.
std::string to_text(double value);
/// "0.1 to 5000", or "at least 0", "at most 5", "any number" where an end is infinite.
std::string to_text(Range range);

/// InputError with `what`, the value and the range when the value is outside, in a unit of `size` in SI:
/// "gamma 200 g: 0.00102041 to 100 g is allowed".
void require_allowed(std::string_view what, double value, Range allowed, std::string_view unit = "",
                     double size = 1);

/// The value in SI units. A number without a unit is in SI; the comma of "1,5g" is a decimal point. Throws
/// InputError with `what`, the text, the units and the allowed range (both ends included); also for NaN.
double parse_quantity(std::string_view what, std::string_view text, Dimension dimension, Range allowed);

}  // namespace shaker
