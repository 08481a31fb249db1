#include "tracking/clipping.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

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

constexpr double clipped_share_from = 0.05;
constexpr int beside_box = 6;                    // px around the box
constexpr int site_rows = 8, site_columns = 64;  // that are compared with the picture before
constexpr std::size_t levels_from = 5;           // one of so many sites shows the levels
constexpr double bright_side = 0.15;  // of the contrast, from its ends: what is bright, what is dark
constexpr double pairs_fade = 0.5, many_pairs = 100;
constexpr double fewest_pairs = 20, still_from = 0.85, restless_to = 0.4, heap_from = 0.5;

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

bool ClippingWatch::clipped(const ImageView& image, const Box& box, bool noisy) {
    const Box around{box.x0 - beside_box, box.y0 - beside_box, box.x1 + beside_box, box.y1 + beside_box};
    compare(image);
    remember(image, around);
    const auto share = [](const Pairs& p) { return p.all >= fewest_pairs ? p.equal / p.all : 0.5; };
    const bool restless = noisy && dark_.all >= fewest_pairs && share(dark_) <= restless_to;
    return (restless && (share(bright_) >= still_from || share(heap_) > heap_from)) ||
           clipped_share(image, box) > clipped_share_from;
}

void ClippingWatch::compare(const ImageView& image) {
    Pairs bright, dark;
    const double margin = bright_side * (high_ - low_);
    const int bright_from = static_cast<int>(std::floor(high_ - margin)) + 1,
              dark_to = static_cast<int>(std::ceil(low_ + margin)) - 1;
    with_pixels(image, [&](auto pixels) {
        for (std::size_t i = 0; i < sites_.size(); ++i) {
            const auto [x, y] = sites_[i];
            if (x >= image.width || y >= image.height) continue;
            const int now = pixels.row(y)[x], before = codes_[i];
            const bool is_bright = std::min(now, before) >= bright_from;
            if (!is_bright && std::max(now, before) > dark_to) continue;
            Pairs& p = is_bright ? bright : dark;
            p.all += 1;
            p.equal += now == before;
        }
    });
    for (const auto& [newest, kept] : {std::pair{&bright, &bright_}, {&dark, &dark_}}) {
        const double old = newest->all < many_pairs ? pairs_fade : 0;
        *kept = {old * kept->all + newest->all, old * kept->equal + newest->equal};
    }
}

void ClippingWatch::remember(const ImageView& image, const Box& box) {
    const int x0 = std::max(box.x0, 0), x1 = std::min(box.x1, image.width);
    const int y0 = std::max(box.y0, 0), y1 = std::min(box.y1, image.height);
    sites_.clear();
    codes_.clear();
    heap_ = {};
    constexpr std::size_t most = site_rows * site_columns;
    sites_.reserve(most), codes_.reserve(most), sorted_.reserve(most);
    if (x0 >= x1 || y0 >= y1) return;
    const int rows = std::min(site_rows, y1 - y0), columns = std::min(site_columns, x1 - x0);
    with_pixels(image, [&](auto pixels) {
        for (int r = 0; r < rows; ++r)
            for (int c = 0; c < columns; ++c) {
                const int x = x0 + (2 * c + 1) * (x1 - x0) / (2 * columns);
                const int y = y0 + (2 * r + 1) * (y1 - y0) / (2 * rows);
                sites_.push_back({x, y});
                codes_.push_back(static_cast<std::uint16_t>(pixels.row(y)[x]));
            }
    });
    sorted_.clear();
    for (std::size_t i = 0; i < codes_.size(); i += levels_from) sorted_.push_back(codes_[i]);
    const auto end = static_cast<std::ptrdiff_t>(codes_.size() / 100);  // hot and dead pixels are beyond it
    std::ranges::nth_element(sorted_, sorted_.begin() + end);
    low_ = *(sorted_.begin() + end);
    std::ranges::nth_element(sorted_, sorted_.end() - 1 - end);
    high_ = *(sorted_.end() - 1 - end);
    for (const std::uint16_t code : codes_)
        if (code > high_ - bright_side * (high_ - low_)) heap_.all += 1, heap_.equal += code == high_;
}

}  // namespace shaker::tracking
