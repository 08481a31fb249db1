#pragma once
// MixerMemory: mapped file shared by a mock mixer's owner and the plug-in of libasound.
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace shaker::mock {

struct MixerMemory {
    static constexpr std::uint64_t version = 0x73686b6d6f636b21;
    struct Control {
        const char* name;
        bool is_switch;   // 0 or 1; else 0 to 255
        bool by_itself;   // its value changes without anybody: a meter
        unsigned values;  // channels
    };
    static constexpr std::array<Control, 3> controls{Control{"Line 3/4 Playback Volume", false, false, 2},
                                                     Control{"Line 3/4 Playback Switch", true, false, 1},
                                                     Control{"Level Meter", false, true, 1}};

    std::atomic<std::uint64_t> ready;  // == version when everything else is initialised
    std::array<std::array<std::atomic<long>, 2>, controls.size()> values;
    std::atomic<std::uint64_t> reads;
};

}  // namespace shaker::mock
