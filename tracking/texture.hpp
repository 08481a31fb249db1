#pragma once
// A piece of picture that can be shifted by fractions of a pixel.
#include <vector>

#include "tracking/pixels.hpp"

namespace shaker {

/// Cubic B-spline through the pixels of a box. Evaluates itself on the box's own grid shifted by up to one
/// pixel; the support needs five pixels around the box, mirrored where the image ends.
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
    /// The same derivatives of the texture smoothed by a binomial of 5 px. Their noise does not know the
    /// noise of value(), so that weighing residuals with them does not pull shifts towards half pixels.
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

}  // namespace shaker
