#pragma once
// Whether this build is fast enough to be judged against real time.

namespace shaker::test {

/// A sanitiser's build is too slow for real time: data come late there, the DAC runs empty. What is left to
/// be shown is that threads and memory are in order.
inline constexpr bool in_real_time = SHAKER_SANITIZED == 0;

}  // namespace shaker::test
