// Two mock cameras, TOP at 127.0.0.1 and SIDE at 127.0.0.2, and a command in the same private network:
// mock_cameras COMMAND [ARGUMENT...]. Exits with the command's status; 77 when the kernel refuses the
// network.
#include <array>
#include <chrono>
#include <stop_token>
#include <string>
#include <thread>

#include "tests/mock/gige_camera.hpp"
#include "tests/support/command.hpp"

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

void expose(const std::stop_token& stop, std::array<mock::GigeCamera*, 2> cameras) {
    const std::array<FramePtr, 2> pictures{ramp(512, 256, 0), ramp(640, 128, 100)};
    const auto began = std::chrono::steady_clock::now();
    for (auto due = began; !stop.stop_requested(); due += period) {
        std::this_thread::sleep_until(due);
        for (std::size_t i = 0; i < cameras.size(); ++i)
            cameras[i]->push(pictures[i], std::chrono::nanoseconds{due - began}.count());
    }
}

}  // namespace

int main(int argc, char** argv) {
    const std::array<std::string, 1> second{"127.0.0.2"};
    return test::run_among_mocks({argv, static_cast<std::size_t>(argc)}, second, [](const auto& run_command) {
        mock::GigeCamera top{{.serial = "TOP", .width = 512, .height = 256}};
        mock::GigeCamera side{{.address = "127.0.0.2", .serial = "SIDE", .width = 640, .height = 128}};
        const std::jthread world{[&](const std::stop_token& stop) { expose(stop, {&top, &side}); }};
        return run_command();
    });
}
