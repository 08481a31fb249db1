#pragma once
// Plays the test drive in the way of the output loop.
#include <vector>

#include "drivers/devices.hpp"
#include "tests/support/devices/mock_dac.hpp"

namespace shaker::test {

/// Counts ticks including lost samples, as every user of a Dac must.
struct Player {
    static constexpr std::size_t block = 440;  // not a multiple of the period of the device or of the drive

    Dac& dac;
    std::int64_t next = 0;                // tick of the next block
    std::vector<PlayTime> lost{};         // answers of write() that report lost time
    std::vector<std::int64_t> resumed{};  // first tick after each of them
    std::vector<double> still = std::vector<double>(block);

    PlayTime play(std::size_t blocks = 1) {
        PlayTime played;
        for (std::size_t i = 0; i < blocks; ++i) {
            played = dac.write(test_block(next, block), still);
            next += static_cast<std::int64_t>(block) + played.lost;
            if (played.lost == 0) continue;
            lost.push_back(played);
            resumed.push_back(next);
        }
        return played;
    }
};

}  // namespace shaker::test
