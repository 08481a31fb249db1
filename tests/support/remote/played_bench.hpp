#pragma once
// A simulated bench port with a thread of its own: for tests of the remote side.
#include <chrono>
#include <thread>

#include "tests/support/remote/played_port.hpp"

namespace shaker::test {

class PlayedBench : public PlayedPort {
    std::jthread thread_{[this](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
            turn();
            std::this_thread::sleep_for(std::chrono::milliseconds{1});
        }
    }};
};

}  // namespace shaker::test
