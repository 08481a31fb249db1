// Two mock cameras, TOP at 127.0.0.1 and SIDE at 127.0.0.2, in a network of their own, and a command that
// sees them: mock_cameras COMMAND [ARGUMENT...]. Exits with the command's status; 77 when the kernel refuses
// the network.
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstring>
#include <exception>
#include <iostream>
#include <stop_token>
#include <thread>

#include "drivers/mock/gige_camera.hpp"
#include "drivers/mock/loopback.hpp"

namespace {

using namespace shaker;

constexpr std::chrono::milliseconds period{10};

FramePtr ramp(int width, int height, int shift) {
    auto frame = std::make_shared<Frame>();
    frame->width = width;
    frame->height = height;
    frame->pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t i = 0; i < frame->pixels.size(); ++i)
        frame->pixels[i] = static_cast<std::byte>(i + static_cast<std::size_t>(shift));
    return frame;
}

void expose(const std::stop_token& stop, std::array<GigeCamera*, 2> cameras) {
    const std::array<FramePtr, 2> pictures{ramp(512, 256, 0), ramp(640, 128, 100)};
    const auto began = std::chrono::steady_clock::now();
    for (auto due = began; !stop.stop_requested(); due += period) {
        std::this_thread::sleep_until(due);
        for (std::size_t i = 0; i < cameras.size(); ++i)
            cameras[i]->push(pictures[i], std::chrono::nanoseconds{due - began}.count());
    }
}

int run(char** command) {
    pid_t pid = 0;
    if (const int error = posix_spawnp(&pid, command[0], nullptr, nullptr, command, environ); error != 0) {
        std::cerr << command[0] << ": " << std::strerror(error) << '\n';
        return 127;
    }
    int status = 0;
    waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc < 2) {
        std::cerr << "usage: mock_cameras COMMAND [ARGUMENT...]\n";
        return 2;
    }
    const std::array<std::string, 1> second{"127.0.0.2"};
    if (const std::string refused = enter_private_network(second); !refused.empty()) {
        std::cerr << refused << '\n';
        return 77;
    }
    GigeCamera top{{.serial = "TOP", .width = 512, .height = 256}};
    GigeCamera side{{.address = "127.0.0.2", .serial = "SIDE", .width = 640, .height = 128}};
    const std::jthread world{[&](const std::stop_token& stop) { expose(stop, {&top, &side}); }};
    return run(argv + 1);
} catch (const std::exception& error) {
    std::cerr << "mock_cameras: " << error.what() << '\n';
    return 1;
}
