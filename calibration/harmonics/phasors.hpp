#pragma once
// Points of the unit circle in blocks, in plain arithmetic that compilers vectorise; the result is the same
// to the bit with any instructions.
#include <array>
#include <complex>
#include <cstddef>
#include <span>

/// A function that is compiled for AVX2 and for any processor; the first call chooses. Functions marked
/// SHAKER_WITHIN become part of it.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define SHAKER_WIDE [[gnu::target_clones("avx2", "default")]]
#else
#define SHAKER_WIDE
#endif
#define SHAKER_WITHIN [[gnu::always_inline]] inline

namespace shaker::calibration {

/// A block of complex numbers, uninitialised.
struct Phasors {
    static constexpr std::size_t size = 128;
    alignas(64) std::array<double, size> re, im;
};

/// e^{2 pi i turns} for a block, |turns| < 2^50, error within 2e-15.
SHAKER_WITHIN Phasors phasors(const std::array<double, Phasors::size>& turns) noexcept {
    constexpr double to_whole = 0x1.8p52;  // adding and subtracting it rounds to a whole number
    constexpr double quarter_turn = 1.57079632679489661923;
    Phasors z;
    for (std::size_t i = 0; i < Phasors::size; ++i) {
        // A quarter of the angle, |h| <= pi/4, by power series; then squared twice.
        const double whole = (turns[i] + to_whole) - to_whole;
        const double h = (turns[i] - whole) * quarter_turn, x = h * h;
        double s = -1 / 1307674368000.0;  // 15!
        s = s * x + 1 / 6227020800.0;
        s = s * x - 1 / 39916800.0;
        s = s * x + 1 / 362880.0;
        s = s * x - 1 / 5040.0;
        s = s * x + 1 / 120.0;
        s = s * x - 1 / 6.0;
        s = s * x * h + h;
        double c = 1 / 20922789888000.0;  // 16!
        c = c * x - 1 / 87178291200.0;
        c = c * x + 1 / 479001600.0;
        c = c * x - 1 / 3628800.0;
        c = c * x + 1 / 40320.0;
        c = c * x - 1 / 720.0;
        c = c * x + 1 / 24.0;
        c = c * x - 1 / 2.0;
        c = c * x + 1;
        const double c2 = 1 - 2 * s * s, s2 = 2 * s * c;
        z.re[i] = 1 - 2 * s2 * s2;
        z.im[i] = 2 * s2 * c2;
    }
    return z;
}

/// a = a b.
SHAKER_WITHIN void multiply(Phasors& a, const Phasors& b) noexcept {
    for (std::size_t i = 0; i < Phasors::size; ++i) {
        const double re = a.re[i] * b.re[i] - a.im[i] * b.im[i];
        a.im[i] = a.re[i] * b.im[i] + a.im[i] * b.re[i];
        a.re[i] = re;
    }
}

/// sum_{q>=1} a[q-1] z^q.
SHAKER_WITHIN Phasors polynomial(std::span<const std::complex<double>> a, const Phasors& z) noexcept {
    Phasors sum{};
    for (auto it = a.rbegin(); it != a.rend(); ++it) {
        const double re = it->real(), im = it->imag();
        for (std::size_t i = 0; i < Phasors::size; ++i) {
            sum.re[i] += re;
            sum.im[i] += im;
        }
        multiply(sum, z);
    }
    return sum;
}

}  // namespace shaker::calibration
