#pragma once
// A piece of picture that can be shifted by fractions of a pixel.
#include <vector>

#include "tracking/pixels.hpp"

namespace shaker {

/// Cubic B-spline through the pixels of a box. Evaluates itself on the box's own grid shifted by up to one
/// pixel; the support needs two pixels around the box, mirrored where the image ends.
class Texture {
public:
    Texture() = default;
    Texture(const ImageView& image, const Box& box);
    /// Fills value, d/dx and d/dy at every pixel p of the box with the texture at p - shift, |shift| <= 1.
    void shift(Point shift);
    [[nodiscard]] const Box& box() const noexcept { return box_; }
    [[nodiscard]] int width() const noexcept { return box_.x1 - box_.x0; }
    [[nodiscard]] int height() const noexcept { return box_.y1 - box_.y0; }
    [[nodiscard]] const double* value(int y) const noexcept { return value_.data() + at(y); }
    [[nodiscard]] const double* dx(int y) const noexcept { return dx_.data() + at(y); }
    [[nodiscard]] const double* dy(int y) const noexcept { return dy_.data() + at(y); }

private:
    [[nodiscard]] std::size_t at(int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width());
    }
    static constexpr int margin = 3;
    Box box_;
    std::vector<double> coefficients_;  // of the box with its margin
    std::vector<double> row_value_, row_dx_, value_, dx_, dy_;
};

}  // namespace shaker
