#include "drivers/response/sensor_response.hpp"

#include <cmath>

namespace shaker {

namespace {

using Complex = std::complex<double>;
constexpr Complex i{0, 1};

/// The denominator at x, and its derivative.
Complex denominator(Complex ix, int poles, double damping) {
    return poles == 2 ? 1.0 + 2 * damping * ix + ix * ix : 1.0 + ix;
}
Complex by_ix(Complex ix, int poles, double damping) {
    return poles == 2 ? 2 * damping + 2.0 * ix : Complex{1};
}

/// Phase per x of a low-pass at low frequencies.
double first_order(const LowPass& pass) { return pass.poles == 2 ? 2 * pass.damping : 1; }

}  // namespace

Complex LowerCorner::at(double frequency_hz) const {
    return 1.0 / denominator(-i * hz / frequency_hz, poles, damping);
}

Complex LowerCorner::log_rate(double frequency_hz) const {
    const Complex ix = -i * hz / frequency_hz;
    return i / frequency_hz * by_ix(ix, poles, damping) / denominator(ix, poles, damping);
}

Complex LowPass::at(double frequency_hz) const {
    if (none()) return 1;
    const double x = frequency_hz / hz;
    return std::polar(1.0, first_order(*this) * x) / denominator(i * x, poles, damping);
}

Complex LowPass::log_rate(double frequency_hz) const {
    if (none()) return 0;
    const double x = frequency_hz / hz;
    const Complex rate = by_ix(i * x, poles, damping) / denominator(i * x, poles, damping);
    return -x / hz * i * (first_order(*this) - rate);
}

double LowPass::phi_error(double f) const {
    if (!none()) return std::abs(phi_turned_by_hz(*this, f)) * error_hz;
    return above_hz > 0 ? std::abs(phi_turned(LowPass{.hz = above_hz}, f)) / 2 : NAN;
}

}  // namespace shaker
