#include "daemon/control/held_drive.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::control {

namespace {
constexpr int least_windows = 10, most_worth = 1000;  // a bench changes slowly
constexpr double clear_of_noise = 8;
}  // namespace

void HeldDrive::begin(int windows) {
    worth_ = windows;
    count_ = 0;
    sum_ = {};
}

bool HeldDrive::add(const Harmonics<Acceleration>& error, double noise, int harmonics) {
    ++count_;
    double most = 0;
    for (int q = 1; q <= max_harmonics; ++q) {
        sum_.at(q) += error.at(q);
        if (q <= harmonics) most = std::max(most, std::abs(sum_.at(q)));
    }
    const bool stands_out = count_ >= least_windows && most > clear_of_noise * noise * std::sqrt(count_);
    if (!stands_out && count_ < longest_hold) return false;
    for (int q = 1; q <= max_harmonics; ++q)
        correction_.at(q) = sum_.at(q) / static_cast<double>(worth_ + count_);
    begin(stands_out ? count_ : std::min(worth_ + count_, most_worth));
    return true;
}

}  // namespace shaker::control
