#include "tracking/image/profile.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>

namespace shaker::tracking {

namespace {

// Row by row, as they lie in memory, so many columns at a time.
constexpr std::size_t strip = 2048, lanes = 16;
constexpr int rows_ahead = 2;  // requested

template <class Sum, class P>
void sum_columns(const P& pixels, int first, int y0, int y1, std::span<double> out) {
    for (std::size_t from = 0; from < out.size(); from += strip) {
        const std::size_t count = std::min(strip, out.size() - from);
        std::array<Sum, strip> sum;
        std::fill_n(sum.begin(), count, Sum{0});
        for (int y = y0; y < y1; ++y) {
            const auto* row = pixels.row(y) + first + from;
            if (y + rows_ahead < y1) request(pixels.row(y + rows_ahead) + first + from, count);
            std::size_t i = 0;
            for (; i + lanes <= count; i += lanes)
                for (std::size_t k = 0; k < lanes; ++k)
                    sum[i + k] = static_cast<Sum>(sum[i + k] + row[i + k]);
            for (; i < count; ++i) sum[i] = static_cast<Sum>(sum[i] + row[i]);
        }
        std::copy_n(sum.begin(), count, out.begin() + static_cast<std::ptrdiff_t>(from));
    }
}

template <class T>
void sum_rows(const Pixels<T>& pixels, int first, int y0, int y1, std::span<double> out) {
    const bool fits = sizeof(T) == 1 && y1 - y0 <= 257;  // times 255
    fits ? sum_columns<std::uint16_t>(pixels, first, y0, y1, out)
         : sum_columns<std::uint32_t>(pixels, first, y0, y1, out);
}

}  // namespace

void mean_profile(const ImageView& image, Axis axis, int first, int across0, int across1,
                  std::span<double> out) {
    with_pixels(image, [&](auto pixels) {
        if (axis == Axis::x) {
            sum_rows(pixels, first, across0, across1, out);
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
