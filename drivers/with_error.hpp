#pragma once
// A value with its standard error, for people.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace shaker {

/// "14.582 +- 0.099": the error with two digits, the value with the same decimals. Without an error that is
/// finite and above 0: the value with six digits. "-" for a value that is not finite.
inline std::string with_error(double value, double sigma) {
    if (!std::isfinite(value)) return "-";
    if (!(sigma > 0) || std::isinf(sigma)) return fmt::format("{:.6g}", value);
    const std::string two = fmt::format("{:.1e}", sigma);  // rounded: 0.0996 is 1.0e-01
    const int digits = std::clamp(1 - std::stoi(two.substr(two.find('e') + 1)), 0, 12);
    return fmt::format("{:.{}f} +- {:.{}f}", value, digits, sigma, digits);
}

}  // namespace shaker
