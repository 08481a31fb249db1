#include "daemon/manual/shared_arguments.hpp"

#include <spdlog/fmt/fmt.h>

namespace shaker::manual {

std::string doubtful_gamma(const Values& values) {
    constexpr double doubtful = 0.2 * paper_g;  // m/s^2
    if (!values.has("--gamma")) return {};
    const std::string text = values.text("--gamma");
    const double gamma = values.number("--gamma");
    if (gamma >= doubtful || text.find_first_not_of("+.0123456789e-") != std::string::npos) return {};
    return fmt::format(
        "gamma {0} m/s^2 is {1:.3g} g; few walkers move at so little. A number without a unit is in m/s^2; "
        "for {0} g give --gamma {0}g",
        text, gamma / paper_g);
}

Drive changed_drive(const Values& values, Drive drive) {
    const auto change = [&](const char* option, double& x) {
        if (values.has(option)) x = values.number(option);
    };
    change("--gamma", drive.gamma);
    change("--phi", drive.phi);
    change("--rho", drive.rho);
    change("--frequency", drive.frequency);
    return drive;
}

}  // namespace shaker::manual
