#include "tests/support/tracking/test_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstring>
#include <numbers>
#include <vector>

namespace shaker::test {
namespace {

double gaussian_step(double t) { return 0.5 * std::erfc(-t / std::numbers::sqrt2); }

// Mean over a pixel of a step at `edge` blurred by a Gaussian: the integral of Phi is t Phi + phi.
double pixel_step(double x, double edge, double blur) {
    const auto integral = [](double t) {
        return t * gaussian_step(t) + std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi);
    };
    return blur * (integral((x + 0.5 - edge) / blur) - integral((x - 0.5 - edge) / blur));
}

constexpr std::array<double, 3> gauss_at{-0.3872983346207417, 0, 0.3872983346207417};
constexpr std::array<double, 3> gauss_weight{5.0 / 18, 8.0 / 18, 5.0 / 18};

// A blurred disc at one point: chords blurred along x in closed form, summed over y with the Gaussian's
// weight.
double disc_at(double x, double y, double radius, double blur) {
    constexpr int steps = 24;
    constexpr double reach = 5.0;
    double sum = 0, total = 0;
    for (int i = 0; i < steps; ++i) {
        const double t = reach * (2.0 * (i + 0.5) / steps - 1), weight = std::exp(-0.5 * t * t);
        const double chord = y + blur * t, half = std::sqrt(std::max(0.0, radius * radius - chord * chord));
        total += weight;
        if (half > 0) {
            sum += weight * (gaussian_step((x + half) / blur) - gaussian_step((x - half) / blur));
        }
    }
    return sum / total;
}

}  // namespace

TestPicture::TestPicture(int width, int height, double level)
    : width_{width},
      height_{height},
      levels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), level) {}

void TestPicture::disc(tracking::Point centre, double radius, double level, double blur) {
    const double reach = 6 * blur + 1;
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            const double r = std::hypot(x - centre.x, y - centre.y);
            double inside = r < radius ? 1 : 0;
            if (std::abs(r - radius) < reach) {
                inside = 0;
                for (std::size_t i = 0; i < 3; ++i) {
                    for (std::size_t j = 0; j < 3; ++j) {
                        const double dx = x + gauss_at[i] - centre.x, dy = y + gauss_at[j] - centre.y;
                        // The rim of a large disc is straight over the blur's width, up to blur^2 / 2 R of
                        // radius.
                        const double share = radius < 12
                                                 ? disc_at(dx, dy, radius, blur)
                                                 : gaussian_step((radius - std::hypot(dx, dy)) / blur);
                        inside += gauss_weight[i] * gauss_weight[j] * share;
                    }
                }
            }
            at(x, y) += inside * (level - at(x, y));
        }
    }
}

void TestPicture::turned(tracking::Point centre, double radius, double strength, std::uint64_t seed) {
    constexpr int waves = 12;
    std::mt19937_64 random{seed};
    std::uniform_real_distribution<double> uniform{0, 1};
    std::array<std::array<double, 2>, waves> all{};
    for (auto& [k, phase] : all) {
        k = 2 * std::numbers::pi / (2.5 + 6.5 * uniform(random));
        phase = 2 * std::numbers::pi * uniform(random);
    }
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            const double r = std::hypot(x - centre.x, y - centre.y);
            const double inside = gaussian_step((radius - r) / 0.8);
            if (inside < 1e-9) continue;
            double sum = 0;
            for (const auto& [k, phase] : all) sum += std::cos(k * r + phase);
            at(x, y) += inside * strength * std::sqrt(2.0 / waves) * sum;
        }
    }
}

void TestPicture::rectangle(double x0, double y0, double x1, double y1, double level, double blur) {
    for (int y = 0; y < height_; ++y) {
        const double rows = pixel_step(y, y0, blur) - pixel_step(y, y1, blur);
        for (int x = 0; x < width_; ++x) {
            const double inside = rows * (pixel_step(x, x0, blur) - pixel_step(x, x1, blur));
            at(x, y) += inside * (level - at(x, y));
        }
    }
}

void TestPicture::bars(double x, double pitch, int y0, int y1, double dark, double bright, double blur) {
    const double first = x - pitch * std::ceil((x + 10 * blur) / pitch + 1);
    for (int column = 0; column < width_; ++column) {
        double share = 0;
        for (double centre = first; centre < width_ + pitch; centre += pitch) {
            if (std::abs(centre - column) > pitch + 10 * blur) continue;
            share +=
                pixel_step(column, centre - pitch / 4, blur) - pixel_step(column, centre + pitch / 4, blur);
        }
        for (int y = y0; y < y1; ++y) at(column, y) = dark + share * (bright - dark);
    }
}

void TestPicture::code(std::span<const double> edges, int y0, int y1, double dark, double bright,
                       double blur) {
    for (int column = 0; column < width_; ++column) {
        double share = 0;
        for (std::size_t k = 0; k + 1 < edges.size(); k += 2)
            share += pixel_step(column, edges[k], blur) - pixel_step(column, edges[k + 1], blur);
        for (int y = y0; y < y1; ++y) at(column, y) = bright + share * (dark - bright);
    }
}

void TestPicture::texture(const tracking::Box& box, tracking::Point shift, double strength,
                          std::uint64_t seed, double turn) {
    constexpr int waves = 30;
    std::mt19937_64 random{seed};
    std::uniform_real_distribution<double> uniform{0, 1};
    struct Wave {
        double kx, ky, phase, amplitude;
    };
    std::array<Wave, waves> all{};
    for (Wave& w : all) {
        const double length = 5 + 15 * uniform(random), angle = 2 * std::numbers::pi * uniform(random);
        const double k = 2 * std::numbers::pi / length;
        w = {k * std::cos(angle), k * std::sin(angle), 2 * std::numbers::pi * uniform(random),
             strength * std::sqrt(2.0 / waves)};
        if (turn == 0) continue;
        const double x = 0.5 * (box.x0 + box.x1 - 1), y = 0.5 * (box.y0 + box.y1 - 1);
        w.phase += w.kx * x + w.ky * y;
        w.kx = k * std::cos(angle + turn), w.ky = k * std::sin(angle + turn);
        w.phase -= w.kx * x + w.ky * y;
    }
    // cos(a + b) by the factors of columns and rows: no cosine a pixel.
    const int x0 = std::max(0, box.x0), x1 = std::min(width_, box.x1);
    for (const Wave& w : all) {
        std::vector<std::complex<double>> column;
        for (int x = x0; x < x1; ++x)
            column.push_back(std::polar(w.amplitude, w.kx * (x - shift.x) + w.phase));
        for (int y = std::max(0, box.y0); y < std::min(height_, box.y1); ++y) {
            const std::complex<double> row = std::polar(1.0, w.ky * (y - shift.y));
            for (int x = x0; x < x1; ++x) {
                const std::complex<double> c = column[static_cast<std::size_t>(x - x0)];
                at(x, y) += c.real() * row.real() - c.imag() * row.imag();
            }
        }
    }
}

void TestPicture::shape(const tracking::Box& box, double level, double blur,
                        const std::function<double(tracking::Point)>& distance) {
    for (int y = std::max(0, box.y0); y < std::min(height_, box.y1); ++y)
        for (int x = std::max(0, box.x0); x < std::min(width_, box.x1); ++x)
            at(x, y) += gaussian_step(-distance({1.0 * x, 1.0 * y}) / blur) * (level - at(x, y));
}

void TestPicture::cover(const tracking::Box& box, double level) {
    for (int y = std::max(0, box.y0); y < std::min(height_, box.y1); ++y) {
        for (int x = std::max(0, box.x0); x < std::min(width_, box.x1); ++x) at(x, y) = level;
    }
}

void TestPicture::light(double gain, double slope) {
    change(
        [&](double level, int x, int) { return level * gain * (1 + slope * (x - 0.5 * width_) / width_); });
}

Shot TestPicture::expose(const Exposure& exposure, std::mt19937_64& random) const {
    Shot shot;
    shot.width = width_;
    shot.height = height_;
    shot.bytes_per_pixel = exposure.bytes_per_pixel;
    shot.stride = std::ptrdiff_t{width_} * exposure.bytes_per_pixel + exposure.padding;
    shot.pixels.assign(static_cast<std::size_t>(shot.stride * height_), std::byte{0xa5});
    std::normal_distribution<double> normal;
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            const double noisy = level(x, y) + (exposure.noise > 0 ? exposure.noise * normal(random) : 0.0);
            const auto count = static_cast<std::uint16_t>(
                std::clamp(std::nearbyint(exposure.depth * noisy), 0.0, exposure.full));
            std::byte* pixel =
                shot.pixels.data() + y * shot.stride + std::ptrdiff_t{x} * exposure.bytes_per_pixel;
            if (exposure.bytes_per_pixel == 2) {
                std::memcpy(pixel, &count, 2);
            } else {
                *pixel = static_cast<std::byte>(count);
            }
        }
    }
    return shot;
}

}  // namespace shaker::test
