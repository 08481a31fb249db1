#include "drivers/hardware/alsa_input/rate_reducer.hpp"

#include <boost/math/special_functions/sinc.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

namespace shaker::alsa_input {

namespace {

constexpr int half_width = 8;  // samples of the reduced rate
constexpr double beta = 10;    // of the window
constexpr double pass = 0.3;   // of the reduced rate
constexpr double cut = 0.5 * (pass + (1 - pass));

std::vector<double> taps_of(int n) {
    if (n == 1) return {1};
    const int delay = half_width * n;
    std::vector<double> taps;
    for (int i = -delay; i <= delay; ++i) {
        const double share = static_cast<double>(i) / delay;
        const double window = std::cyl_bessel_i(0, beta * std::sqrt(std::max(0.0, 1 - share * share)));
        taps.push_back(window * boost::math::sinc_pi(2 * std::numbers::pi * cut * i / n));
    }
    const double sum = std::accumulate(taps.begin(), taps.end(), 0.0);
    for (double& t : taps) t /= sum;
    return taps;
}

}  // namespace

RateReducer::RateReducer(int n) : delay_{n == 1 ? 0 : half_width * n}, taps_{taps_of(n)} {
    for (auto& axis : newest_) axis.resize(2 * taps_.size());
}

void RateReducer::add(const std::array<double, 3>& sample) noexcept {
    for (std::size_t k = 0; k < 3; ++k) newest_[k][next_] = newest_[k][next_ + taps_.size()] = sample[k];
    next_ = next_ + 1 == taps_.size() ? 0 : next_ + 1;
}

std::array<double, 3> RateReducer::value() const noexcept {
    std::array<double, 3> out{};
    for (std::size_t k = 0; k < 3; ++k)
        out[k] = std::inner_product(taps_.begin(), taps_.end(),
                                    newest_[k].begin() + static_cast<std::ptrdiff_t>(next_), 0.0);
    return out;
}

}  // namespace shaker::alsa_input
