#pragma once
// Pictures with exactly known edges: the reference for tracking.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include "drivers/data.hpp"
#include "tracking/image/pixels.hpp"

namespace shaker::test {

/// A picture as a camera delivers it. Rows may be padded.
struct Shot {
    std::vector<std::byte> pixels;
    int width = 0, height = 0, bytes_per_pixel = 1;
    std::ptrdiff_t stride = 0;
    [[nodiscard]] ImageView view() const noexcept {
        return {pixels.data(), width, height, stride, bytes_per_pixel};
    }
};

/// Effects of the sensor.
struct Exposure {
    int bytes_per_pixel = 1;
    double noise = 0;   // standard deviation, in the picture's grey levels
    double depth = 1;   // counts per grey level; the sum is rounded and clipped at `full`
    double full = 255;  // counts
    int padding = 0;    // bytes after each row
};

/// Grey levels before the sensor. Shapes are blurred by a Gaussian of `blur` px and averaged over each pixel;
/// the integrals are done in closed form or by quadrature, not by the formulas that tracking fits.
class TestPicture {
public:
    TestPicture(int width, int height, double level);
    void disc(tracking::Point centre, double radius, double level, double blur);
    /// Adds what a lathe leaves on the face of a disc: rings about its centre, of rms `strength`, with
    /// periods of 2.5 to 9 px. Same seed, same rings.
    void turned(tracking::Point centre, double radius, double strength, std::uint64_t seed);
    /// Box from (x0, y0) to (x1, y1), edges at the given places.
    void rectangle(double x0, double y0, double x1, double y1, double level, double blur);
    /// Bars across x, half bright and half dark, one bright one centred at x; rows y0 <= y < y1.
    void bars(double x, double pitch, int y0, int y1, double dark, double bright, double blur);
    /// Dark bars across x from edges[0] to edges[1], from edges[2] to edges[3], ...; rows y0 <= y < y1.
    void code(std::span<const double> edges, int y0, int y1, double dark, double bright, double blur);
    /// Adds a texture of rms `strength` around zero inside `box`, moved by `shift` and turned by `turn` (rad)
    /// about the moved middle of the box. Same seed, same texture.
    void texture(const tracking::Box& box, tracking::Point shift, double strength, std::uint64_t seed,
                 double turn = 0);
    /// A shape by its outline: `distance` of a point from it, px, negative inside; its edges are straight
    /// over the blur's width. box: where it may be.
    void shape(const tracking::Box& box, double level, double blur,
               const std::function<double(tracking::Point)>& distance);
    /// Draws an obstacle in front.
    void cover(const tracking::Box& box, double level);
    /// Sets each level to change(level, x, y).
    void change(auto&& change) {
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) at(x, y) = change(at(x, y), x, y);
    }
    /// Multiplies by gain (1 + slope (x - middle) / width).
    void light(double gain, double slope);
    [[nodiscard]] Shot expose(const Exposure& exposure, std::mt19937_64& random) const;
    [[nodiscard]] int width() const noexcept { return width_; }
    [[nodiscard]] int height() const noexcept { return height_; }
    [[nodiscard]] double level(int x, int y) const noexcept {
        return *(levels_.data() + std::ptrdiff_t{y} * width_ + x);
    }

private:
    double& at(int x, int y) noexcept { return *(levels_.data() + std::ptrdiff_t{y} * width_ + x); }
    int width_, height_;
    std::vector<double> levels_;
};

}  // namespace shaker::test
