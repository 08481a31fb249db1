#include "tracking/clipping.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace shaker::tracking {

namespace {

constexpr int most_rows = 32;

// A code that ends a range: at least eight ones, and only zeros below them.
bool ends_a_range(unsigned code) {
    const unsigned ones = code >> std::countr_zero(code);
    return ones >= 255 && std::has_single_bit(ones + 1);
}

// Sixteen at a time, which the compiler makes one instruction.
template <class T>
unsigned largest_of(const T* row, int n) {
    constexpr int lanes = 16;
    std::array<T, lanes> most{};
    int x = 0;
    for (; x + lanes <= n; x += lanes)
        for (int i = 0; i < lanes; ++i) most[i] = std::max(most[i], row[x + i]);
    for (; x < n; ++x) most[0] = std::max(most[0], row[x]);
    return *std::ranges::max_element(most);
}

}  // namespace

double clipped_share(const ImageView& image, const Box& box) {
    const int x0 = std::max(box.x0, 0), x1 = std::min(box.x1, image.width);
    const int y0 = std::max(box.y0, 0), y1 = std::min(box.y1, image.height);
    if (x0 >= x1 || y0 >= y1) return 0;
    const int step = (y1 - y0 + most_rows - 1) / most_rows;
    return with_pixels(image, [&](auto pixels) {
        unsigned largest = 0;
        for (int y = y0; y < y1; y += step)
            largest = std::max(largest, largest_of(pixels.row(y) + x0, x1 - x0));
        if (largest == 0 || !ends_a_range(largest)) return 0.0;
        int clipped = 0, all = 0;
        for (int y = y0; y < y1; y += step, all += x1 - x0)
            clipped += static_cast<int>(std::count(pixels.row(y) + x0, pixels.row(y) + x1, largest));
        return static_cast<double>(clipped) / all;
    });
}

}  // namespace shaker::tracking
