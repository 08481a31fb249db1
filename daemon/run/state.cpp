#include "daemon/run/state.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace shaker::run {

bool may_follow(RunState from, RunState to) noexcept {
    using enum RunState;
    // A loop check starts again when the DAC runs empty again.
    constexpr std::array ways{
        std::pair{init, self_test},   std::pair{self_test, idle},     std::pair{idle, armed},
        std::pair{armed, idle},       std::pair{armed, identify},     std::pair{armed, ramp},
        std::pair{identify, ramp},    std::pair{identify, ramp_down}, std::pair{ramp, run},
        std::pair{ramp, ramp_down},   std::pair{run, ramp},           std::pair{run, ramp_down},
        std::pair{armed, loop_check}, std::pair{loop_check, ramp},    std::pair{loop_check, ramp_down},
        std::pair{ramp, loop_check},  std::pair{run, loop_check},     std::pair{loop_check, loop_check},
        std::pair{ramp_down, idle},   std::pair{tripped, idle},       std::pair{tripped, init}};
    return (to == tripped && from != tripped) || std::ranges::find(ways, std::pair{from, to}) != ways.end();
}

}  // namespace shaker::run
