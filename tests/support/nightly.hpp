#pragma once
// Tests at full length: tests/run --nightly.
#include <cstdlib>
#include <string_view>

namespace shaker::test {

/// True with SHAKER_NIGHTLY=1 in the environment.
inline bool nightly() {
    const char* const set = std::getenv("SHAKER_NIGHTLY");
    return set != nullptr && std::string_view{set} == "1";
}

}  // namespace shaker::test
