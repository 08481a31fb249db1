#include "daemon/law/fit.hpp"

#include <spdlog/fmt/fmt.h>

namespace shaker::law {

std::string misfit(double chi2, int freedom, const std::string& what) {
    if (freedom < 1 || !(chi2 > freedom + 5 * std::sqrt(2.0 * freedom))) return {};
    return fmt::format("chi^2 is {:.3g} times its degrees of freedom: {}", chi2 / freedom, what);
}

}  // namespace shaker::law
