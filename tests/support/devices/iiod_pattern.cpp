#include "tests/support/devices/iiod_pattern.hpp"

#include <chrono>
#include <cmath>
#include <vector>

namespace shaker::test {

namespace {
std::int64_t now_ns() {
    return std::chrono::nanoseconds{std::chrono::steady_clock::now().time_since_epoch()}.count();
}
}  // namespace

PatternFeeder::PatternFeeder(mock::Iiod& iiod, double rate_hz)
    : step_ns_{1e9 / rate_hz}, first_ns_{now_ns()}, thread_{[this, &iiod](const std::stop_token& stop) {
          run(stop, iiod);
      }} {}

void PatternFeeder::run(const std::stop_token& stop, mock::Iiod& iiod) {
    constexpr std::chrono::milliseconds pause{2};
    std::vector<mock::IiodSample> samples;
    for (std::int64_t n = 0; !stop.stop_requested(); std::this_thread::sleep_for(pause)) {
        const auto due = static_cast<std::int64_t>(static_cast<double>(now_ns() - first_ns_) / step_ns_);
        samples.clear();
        for (; n < due; ++n)
            samples.push_back({pattern(n), first_ns_ + std::llround(step_ns_ * static_cast<double>(n))});
        iiod.push(samples);
        pushed_ = n;
    }
}

}  // namespace shaker::test
