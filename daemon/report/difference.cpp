#include "daemon/report/difference.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace shaker::report {

std::string speed_difference(const calibration::Estimate& measured, double expected, int digits) {
    const double off = measured.value - expected;
    std::string text = fmt::format("{:+.3f} um/s", 1e6 * off);
    constexpr double negligible = 1e-9;  // m/s: where no error is known
    const double error = std::isfinite(measured.sigma) ? std::abs(measured.sigma) : 0;
    if (std::abs(expected) > std::max(error, negligible))
        text += fmt::format(" = {:+.{}f} %", 100 * off / std::abs(expected), digits);
    return text;
}

}  // namespace shaker::report
