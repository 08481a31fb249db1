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

template <class Sum, class P, class Mean>
void sum_columns(const P& pixels, int first, int y0, int y1, std::span<Mean> out) {
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
        const auto scale = static_cast<Mean>(1.0 / (y1 - y0));
        for (std::size_t i = 0; i < count; ++i) out[from + i] = scale * static_cast<Mean>(sum[i]);
    }
}

template <class T, class Mean>
void sum_rows(const Pixels<T>& pixels, int first, int y0, int y1, std::span<Mean> out) {
    const bool fits = sizeof(T) == 1 && y1 - y0 <= 257;  // times 255
    fits ? sum_columns<std::uint16_t>(pixels, first, y0, y1, out)
         : sum_columns<std::uint32_t>(pixels, first, y0, y1, out);
}

template <class Mean>
void means(const ImageView& image, Axis axis, int first, int across0, int across1, std::span<Mean> out) {
    with_pixels(image, [&](auto pixels) {
        if (axis == Axis::x) return sum_rows(pixels, first, across0, across1, out);
        for (std::size_t i = 0; i < out.size(); ++i) {
            const auto* row = pixels.row(first + static_cast<int>(i));
            const double sum = std::accumulate(row + across0, row + across1, 0.0);
            out[i] = static_cast<Mean>(sum / (across1 - across0));
        }
    });
}

}  // namespace

void mean_profile(const ImageView& image, Axis axis, int first, int across0, int across1,
                  std::span<double> out) {
    means(image, axis, first, across0, across1, out);
}

void mean_profile(const ImageView& image, Axis axis, int first, int across0, int across1,
                  std::span<float> out) {
    means(image, axis, first, across0, across1, out);
}

}  // namespace shaker::tracking
