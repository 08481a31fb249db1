// Response of a sensor: its derivatives, its limits, the paper's phi.
#include "drivers/response/sensor_response.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace shaker {
namespace {

template <class Part>
void expect_rate(Part part, double f) {
    constexpr double step = 1e-6;
    Part up = part, down = part;
    up.hz *= 1 + step;
    down.hz *= 1 - step;
    const std::complex<double> numeric = std::log(up.at(f) / down.at(f)) / (2 * step * part.hz),
                               stated = part.log_rate(f);
    EXPECT_NEAR(numeric.real(), stated.real(), 1e-7 * std::abs(stated) + 1e-12) << part.hz << " " << f;
    EXPECT_NEAR(numeric.imag(), stated.imag(), 1e-7 * std::abs(stated) + 1e-12) << part.hz << " " << f;
}

TEST(SensorResponseTest, DerivativesAreThoseOfTheResponse) {
    for (const double damping : {1.0, 0.7071, 0.5})
        for (const int poles : {1, 2})
            for (const double f : {5.0, 20.0, 160.0}) {
                expect_rate(LowerCorner{.hz = 3, .poles = poles, .damping = damping}, f);
                expect_rate(LowPass{.hz = 400, .poles = poles, .damping = damping}, f);
            }
}

TEST(SensorResponseTest, ALowPassHasNoDelayAtLowFrequencies) {
    for (const int poles : {1, 2}) {
        const LowPass pass{.hz = 500, .poles = poles};
        EXPECT_NEAR(std::arg(pass.at(0.5)), 0, 1e-8);
        EXPECT_NEAR(std::abs(pass.at(500)), std::sqrt(0.5), 1e-12);
    }
}

TEST(SensorResponseTest, TurnsPhiAsAPoleDoes) {
    const LowerCorner corner{.hz = 0.33};
    EXPECT_NEAR(phi_turned(corner, 20), std::atan(0.33 / 40) - 2 * std::atan(0.33 / 20), 1e-15);
    const LowerCorner equal{.hz = 0.33, .poles = 2};
    EXPECT_NEAR(phi_turned(equal, 20), 2 * phi_turned(corner, 20), 1e-14);
    const LowerCorner butterworth{.hz = 3, .poles = 2, .damping = std::sqrt(0.5)};
    EXPECT_NEAR(std::abs(butterworth.at(3)), std::sqrt(0.5), 1e-12);
    EXPECT_EQ(phi_turned(LowPass{}, 20), 0);
}

}  // namespace
}  // namespace shaker
