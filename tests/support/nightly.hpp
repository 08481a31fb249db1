#pragma once
// Tests at full length: tests/run --nightly.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>

namespace shaker::test {

/// True with SHAKER_NIGHTLY=1 in the environment.
inline bool nightly() {
    const char* const set = std::getenv("SHAKER_NIGHTLY");
    return set != nullptr && std::string_view{set} == "1";
}

/// How often a test plays its case: `gate` times, `night` times at full length, or as often as SHAKER_COUNT
/// says.
inline int plays(int gate, int night) {
    const char* const set = std::getenv("SHAKER_COUNT");
    if (set != nullptr) return std::max(1, std::atoi(set));
    return nightly() ? night : gate;
}
/// SHAKER_SEED, or `otherwise`.
inline std::uint64_t seed_of_day(std::uint64_t otherwise) {
    const char* const set = std::getenv("SHAKER_SEED");
    return set == nullptr ? otherwise : std::strtoull(set, nullptr, 10);
}

}  // namespace shaker::test
