#pragma once
// Typed access to a picture's pixels, 8 or 16 bit, without converting them.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "drivers/data.hpp"

namespace shaker::tracking {

/// A point in the image, px; pixel centres are at whole numbers.
struct Point {
    double x = 0;
    double y = 0;
};
constexpr Point operator+(Point a, Point b) noexcept { return {a.x + b.x, a.y + b.y}; }
constexpr Point operator-(Point a, Point b) noexcept { return {a.x - b.x, a.y - b.y}; }
constexpr Point operator*(double s, Point a) noexcept { return {s * a.x, s * a.y}; }
inline double length(Point a) noexcept { return std::hypot(a.x, a.y); }
inline bool finite(Point a) noexcept { return std::isfinite(a.x) && std::isfinite(a.y); }

/// Half-open box of pixels, x0 <= x < x1.
struct Box {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] constexpr bool contains(int x, int y) const noexcept {
        return x >= x0 && x < x1 && y >= y0 && y < y1;
    }
};

/// The image axis a one-dimensional method measures along.
enum class Axis { x, y };

/// Typed rows of an ImageView.
template <class T>
class Pixels {
public:
    explicit Pixels(const ImageView& image) noexcept : image_{image} {}
    [[nodiscard]] const T* row(int y) const noexcept { return reinterpret_cast<const T*>(image_.row(y)); }
    [[nodiscard]] double at(int x, int y) const noexcept { return static_cast<double>(row(y)[x]); }

private:
    ImageView image_;
};

/// Calls f(Pixels<std::uint8_t>) or f(Pixels<std::uint16_t>), depending on the image's depth.
template <class F>
decltype(auto) with_pixels(const ImageView& image, F&& f) {
    if (image.bytes_per_pixel == 2) return f(Pixels<std::uint16_t>{image});
    return f(Pixels<std::uint8_t>{image});
}

/// Requests pixels that are read soon: a picture comes from the memory, not from a cache.
template <class T>
void request(const T* pixels, std::size_t count) noexcept {
    constexpr std::size_t line = 64;  // bytes
    const auto* const bytes = reinterpret_cast<const char*>(pixels);
    for (std::size_t i = 0; i < count * sizeof(T); i += line) __builtin_prefetch(bytes + i);
}

constexpr Box whole(const ImageView& image) noexcept { return {0, 0, image.width, image.height}; }

}  // namespace shaker::tracking
