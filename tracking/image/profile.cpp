#include "tracking/image/profile.hpp"

#include <algorithm>
#include <numeric>

namespace shaker::tracking {

void mean_profile(const ImageView& image, Axis axis, int first, int across0, int across1,
                  std::span<double> out) {
    std::fill(out.begin(), out.end(), 0.0);
    with_pixels(image, [&](auto pixels) {
        if (axis == Axis::x) {
            for (int y = across0; y < across1; ++y) {
                const auto* row = pixels.row(y) + first;
                for (std::size_t i = 0; i < out.size(); ++i) out[i] += static_cast<double>(row[i]);
            }
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
