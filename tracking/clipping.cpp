#include "tracking/clipping.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace shaker::tracking {

namespace {

constexpr int fewest_rows = 6, most_rows = 24, most_pixels = 8000;  // that are looked at

// A code that ends a range: at least eight ones, and only zeros below them.
bool ends_a_range(unsigned code) {
    const unsigned ones = code >> std::countr_zero(code);
    return ones >= 255 && std::has_single_bit(ones + 1);
}

template <class T>
unsigned largest_of(const T* row, int n) {
    constexpr int bytes = 16, count = bytes / static_cast<int>(sizeof(T));
    using Lanes [[gnu::vector_size(bytes)]] = T;
    Lanes most{};
    int x = 0;
    for (; x + count <= n; x += count) {
        Lanes some;
        std::memcpy(&some, row + x, sizeof some);
        most = some > most ? some : most;
    }
    unsigned largest = 0;
    for (int i = 0; i < count; ++i) largest = std::max<unsigned>(largest, most[i]);
    for (; x < n; ++x) largest = std::max<unsigned>(largest, row[x]);
    return largest;
}

}  // namespace

double clipped_share(const ImageView& image, const Box& box) {
    const int x0 = std::max(box.x0, 0), x1 = std::min(box.x1, image.width);
    const int y0 = std::max(box.y0, 0), y1 = std::min(box.y1, image.height);
    if (x0 >= x1 || y0 >= y1) return 0;
    const int rows = std::clamp(most_pixels / (x1 - x0), fewest_rows, most_rows);
    const int step = (y1 - y0 + rows - 1) / rows;
    return with_pixels(image, [&](auto pixels) {
        unsigned largest = 0;
        for (int y = y0; y < y1; y += step) {
            if (y + step < y1) request(pixels.row(y + step) + x0, static_cast<std::size_t>(x1 - x0));
            largest = std::max(largest, largest_of(pixels.row(y) + x0, x1 - x0));
        }
        if (largest == 0 || !ends_a_range(largest)) return 0.0;
        int clipped = 0, all = 0;
        for (int y = y0; y < y1; y += step, all += x1 - x0)
            clipped += static_cast<int>(std::count(pixels.row(y) + x0, pixels.row(y) + x1, largest));
        return static_cast<double>(clipped) / all;
    });
}

}  // namespace shaker::tracking
