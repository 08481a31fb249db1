#pragma once
// The operating system's answer to a request for real time.
#include <string>

namespace shaker::acquisition {

struct RealTimeGrant {
    std::string what;     // "memory" (locked), or the name of a thread (its stack and priority)
    std::string refused;  // reason and remedy; empty: granted
};

}  // namespace shaker::acquisition
