#pragma once
// BarCode: a strip of bars of pseudo-random width, for a base.
#include <cstdint>
#include <vector>

namespace shaker::optics {

/// Dark and bright bars alternate across the strip. Their widths are uniform between the limits and follow
/// from the seed, so the strip resembles itself at one place only.
struct BarCode {
    std::uint64_t seed = 1;
    double length_mm = 200;
    double least_mm = 3, most_mm = 8;  // width of a bar
};

/// Edges in mm from the strip's left end, ascending, an even number: dark from the first to the second, from
/// the third to the fourth, ...; the last one is less than two bars from the strip's right end. Requires
/// 0 < least_mm <= most_mm.
std::vector<double> edges_of(const BarCode& code);

}  // namespace shaker::optics
