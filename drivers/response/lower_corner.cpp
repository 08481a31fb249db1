#include "drivers/response/lower_corner.hpp"

namespace shaker {

std::complex<double> LowerCorner::at(double frequency_hz) const {
    return std::pow(1.0 / std::complex<double>{1, -hz / frequency_hz}, poles);
}

}  // namespace shaker
