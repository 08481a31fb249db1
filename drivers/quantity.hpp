#pragma once
// Numbers with units as a person types them: "1.5g", "14.7 m/s^2", "35deg", "0.61rad", "20Hz", "50ms".
#include <string>
#include <string_view>

namespace shaker {

enum class Dimension { acceleration, angle, frequency, time, velocity, ratio };

/// Both ends included; an end may be infinite.
struct Range {
    double min;
    double max;
};

/// The shortest text that reads back as the same number; the locale does not matter.
std::string to_text(double value);
/// "0.1 to 5000", or "at least 0", "at most 5", "any number" where an end is infinite.
std::string to_text(Range range);

/// The value in SI units. A bare number is SI already. Throws InputError naming `what`, the text, the units
/// that are understood and the allowed range (in SI), both ends included; NaN and infinity are never allowed.
double parse_quantity(std::string_view what, std::string_view text, Dimension dimension, Range allowed);

}  // namespace shaker
