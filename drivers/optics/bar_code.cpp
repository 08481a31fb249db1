#include "drivers/optics/bar_code.hpp"

#include <random>

namespace shaker::optics {

std::vector<double> edges_of(const BarCode& code) {
    constexpr double to_unit = 0x1p-53;  // the standard's distributions differ between libraries
    std::mt19937_64 random{code.seed};
    const auto width = [&] {
        const double share = to_unit * static_cast<double>(random() >> 11U);
        return code.least_mm + share * (code.most_mm - code.least_mm);
    };
    std::vector<double> edges;
    for (double at = width(); at < code.length_mm; at += width()) edges.push_back(at);
    if (edges.size() % 2 != 0) edges.pop_back();
    return edges;
}

}  // namespace shaker::optics
