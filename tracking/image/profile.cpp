#include "tracking/image/profile.hpp"

#include <array>
#include <cstdint>
#include <numeric>

namespace shaker::tracking {

namespace {

// Sums of whole columns from row y0 to y1, of which sixteen at a time become one instruction.
template <class P>
void sum_columns(const P& pixels, int first, int y0, int y1, std::span<double> out) {
    constexpr std::size_t lanes = 16;
    std::size_t i = 0;
    for (; i + lanes <= out.size(); i += lanes) {
        std::array<std::uint32_t, lanes> sum{};
        for (int y = y0; y < y1; ++y) {
            const auto* row = pixels.row(y) + first + i;
            for (std::size_t k = 0; k < lanes; ++k) sum[k] += row[k];
        }
        for (std::size_t k = 0; k < lanes; ++k) out[i + k] = sum[k];
    }
    for (; i < out.size(); ++i) {
        std::uint32_t sum = 0;
        for (int y = y0; y < y1; ++y) sum += pixels.row(y)[first + static_cast<int>(i)];
        out[i] = sum;
    }
}

}  // namespace

void mean_profile(const ImageView& image, Axis axis, int first, int across0, int across1,
                  std::span<double> out) {
    with_pixels(image, [&](auto pixels) {
        if (axis == Axis::x) {
            sum_columns(pixels, first, across0, across1, out);
        } else {
            for (std::size_t i = 0; i < out.size(); ++i) {
                const auto* row = pixels.row(first + static_cast<int>(i));
                out[i] = std::accumulate(row + across0, row + across1, 0.0);
            }
        }
    });
    const double scale = 1.0 / (across1 - across0);
    for (double& v : out) v *= scale;
}

}  // namespace shaker::tracking
