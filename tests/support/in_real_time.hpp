#pragma once
// Whether this build is fast enough for tests in real time.

namespace shaker::test {

/// A build with a sanitiser is too slow for real time: data are late and the DAC runs empty. Its tests only
/// check threads and memory.
inline constexpr bool in_real_time = SHAKER_SANITIZED == 0;

}  // namespace shaker::test
