#pragma once
// A played desk that moves by itself: for tests of the remote side.
#include <chrono>
#include <thread>

#include "tests/support/played_desk.hpp"

namespace shaker::test {

class PlayedBench : public PlayedDesk {
    std::jthread thread_{[this](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
            turn();
            std::this_thread::sleep_for(std::chrono::milliseconds{1});
        }
    }};
};

}  // namespace shaker::test
