#pragma once
// Texture: a part of an image that can be shifted by fractions of a pixel.
#include <vector>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// Cubic B-spline through the pixels of a box, evaluated on the box's grid shifted by up to one pixel. Needs
/// five pixels around the box; they are mirrored at the edge of the image.
class Texture {
public:
    Texture() = default;
    Texture(const ImageView& image, const Box& box);
    /// Sets value, d/dx and d/dy at every pixel p of the box to the texture at p - shift, |shift| <= 1.
    void shift(Point shift);
    [[nodiscard]] const Box& box() const noexcept { return box_; }
    [[nodiscard]] int width() const noexcept { return box_.x1 - box_.x0; }
    [[nodiscard]] int height() const noexcept { return box_.y1 - box_.y0; }
    [[nodiscard]] const double* value(int y) const noexcept { return value_.data() + at(y); }
    [[nodiscard]] const double* dx(int y) const noexcept { return dx_.data() + at(y); }
    [[nodiscard]] const double* dy(int y) const noexcept { return dy_.data() + at(y); }
    /// The derivatives of the texture smoothed by a binomial of 5 px. Their noise is independent of that of
    /// value(), so weighting residuals with them causes no bias towards half pixels.
    [[nodiscard]] const double* smooth_dx(int y) const noexcept { return smooth_dx_.data() + at(y); }
    [[nodiscard]] const double* smooth_dy(int y) const noexcept { return smooth_dy_.data() + at(y); }

private:
    [[nodiscard]] std::size_t at(int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width());
    }
    static constexpr int margin = 5;
    Box box_;
    void evaluate(const std::vector<double>& coefficients, Point shift, double* value, double* dx,
                  double* dy);

    std::vector<double> coefficients_, smooth_;  // of the box with its margin
    std::vector<double> row_value_, row_dx_, value_, dx_, dy_, smooth_value_, smooth_dx_, smooth_dy_;
};

}  // namespace shaker::tracking
