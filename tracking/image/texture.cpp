#include "tracking/image/texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace shaker::tracking {
namespace {

struct Taps {
    std::array<double, 4> value{}, slope{};
};

// Weights of coefficients n - 1 .. n + 2 for the spline at n + f.
Taps taps(double f) noexcept {
    const double g = 1 - f;
    return {{g * g * g / 6, 2.0 / 3 - 0.5 * f * f * (2 - f), 2.0 / 3 - 0.5 * g * g * (2 - g), f * f * f / 6},
            {-0.5 * g * g, f * (1.5 * f - 2), -g * (1.5 * g - 2), 0.5 * f * f}};
}

// Converts samples to coefficients in place (recursive filter of the cubic B-spline, mirrored ends).
void prefilter(double* c, int n, std::ptrdiff_t step) {
    if (n < 2) return;
    const double z = std::sqrt(3.0) - 2;
    const auto at = [&](int i) -> double& { return c[i * step]; };
    double sum = at(0), power = z;
    for (int i = 1; i < std::min(n, 30); ++i, power *= z) sum += power * at(i);
    at(0) = sum;
    for (int i = 1; i < n; ++i) at(i) += z * at(i - 1);
    at(n - 1) = z / (z * z - 1) * (at(n - 1) + z * at(n - 2));
    for (int i = n - 2; i >= 0; --i) at(i) = z * (at(i + 1) - at(i));
    for (int i = 0; i < n; ++i) at(i) *= 6;
}

// Binomial filter of five in place; the two values at each end are unchanged.
void smooth(double* c, int n, std::ptrdiff_t step) {
    if (n < 5) return;
    double a = c[0], b = c[step];
    for (int i = 2; i < n - 2; ++i) {
        double& here = c[i * step];
        const double old = here;
        here = (a + c[(i + 2) * step] + 4 * (b + c[(i + 1) * step]) + 6 * old) / 16;
        a = b;
        b = old;
    }
}

}  // namespace

Texture::Texture(const ImageView& image, const Box& box) : box_{box} {
    const int w = width() + 2 * margin, h = height() + 2 * margin;
    coefficients_.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    const auto mirror = [](int i, int n) { return i < 0 ? -i : i >= n ? 2 * n - 2 - i : i; };
    with_pixels(image, [&](auto pixels) {
        double* out = coefficients_.data();
        for (int y = box.y0 - margin; y < box.y1 + margin; ++y) {
            for (int x = box.x0 - margin; x < box.x1 + margin; ++x) {
                *out++ = pixels.at(mirror(x, image.width), mirror(y, image.height));
            }
        }
    });
    for (int y = 0; y < h; ++y) prefilter(coefficients_.data() + std::ptrdiff_t{y} * w, w, 1);
    for (int x = 0; x < w; ++x) prefilter(coefficients_.data() + x, h, w);
    smooth_ = coefficients_;
    for (int y = 0; y < h; ++y) smooth(smooth_.data() + std::ptrdiff_t{y} * w, w, 1);
    for (int x = 0; x < w; ++x) smooth(smooth_.data() + x, h, w);
    const auto count = static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
    for (auto* v : {&value_, &dx_, &dy_, &smooth_value_, &smooth_dx_, &smooth_dy_}) v->resize(count);
    row_value_.resize(static_cast<std::size_t>(h) * static_cast<std::size_t>(width()));
    row_dx_.resize(row_value_.size());
}

void Texture::shift(Point shift) {
    evaluate(coefficients_, shift, value_.data(), dx_.data(), dy_.data());
    evaluate(smooth_, shift, smooth_value_.data(), smooth_dx_.data(), smooth_dy_.data());
}

void Texture::evaluate(const std::vector<double>& coefficients, Point shift, double* out, double* out_dx,
                       double* out_dy) {
    const int w = width(), wide = w + 2 * margin, tall = height() + 2 * margin;
    const int nx = static_cast<int>(std::floor(-shift.x)), ny = static_cast<int>(std::floor(-shift.y));
    const Taps tx = taps(-shift.x - nx), ty = taps(-shift.y - ny);
    for (int y = 0; y < tall; ++y) {
        const double* c = coefficients.data() + std::ptrdiff_t{y} * wide + margin + nx - 1;
        double* value = row_value_.data() + std::ptrdiff_t{y} * w;
        double* slope = row_dx_.data() + std::ptrdiff_t{y} * w;
        for (int x = 0; x < w; ++x) {
            value[x] =
                tx.value[0] * c[x] + tx.value[1] * c[x + 1] + tx.value[2] * c[x + 2] + tx.value[3] * c[x + 3];
            slope[x] =
                tx.slope[0] * c[x] + tx.slope[1] * c[x + 1] + tx.slope[2] * c[x + 2] + tx.slope[3] * c[x + 3];
        }
    }
    for (int y = 0; y < height(); ++y) {
        const double* v = row_value_.data() + std::ptrdiff_t{y + margin + ny - 1} * w;
        const double* d = row_dx_.data() + std::ptrdiff_t{y + margin + ny - 1} * w;
        for (int x = 0; x < w; ++x) {
            const auto i = at(y) + static_cast<std::size_t>(x);
            const std::array<double, 4> column{v[x], v[x + w], v[x + 2 * w], v[x + 3 * w]};
            out[i] = ty.value[0] * column[0] + ty.value[1] * column[1] + ty.value[2] * column[2] +
                     ty.value[3] * column[3];
            out_dy[i] = ty.slope[0] * column[0] + ty.slope[1] * column[1] + ty.slope[2] * column[2] +
                        ty.slope[3] * column[3];
            out_dx[i] = ty.value[0] * d[x] + ty.value[1] * d[x + w] + ty.value[2] * d[x + 2 * w] +
                        ty.value[3] * d[x + 3 * w];
        }
    }
}

}  // namespace shaker::tracking
