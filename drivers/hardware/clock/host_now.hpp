#pragma once
// Reads the host's monotonic clock. Real-time.
#include <chrono>
#include <ctime>

#include "drivers/time.hpp"

namespace shaker::hardware {

/// Converts a device's CLOCK_MONOTONIC stamp.
inline HostTime host_time(const std::timespec& t) noexcept {
    return HostTime{std::chrono::seconds{t.tv_sec} + std::chrono::nanoseconds{t.tv_nsec}};
}

inline HostTime host_now() noexcept {
    std::timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return host_time(t);
}

}  // namespace shaker::hardware
