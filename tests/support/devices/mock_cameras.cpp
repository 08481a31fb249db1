#include "tests/support/devices/mock_cameras.hpp"

#include <array>

#include "tests/mock/loopback.hpp"

namespace shaker::test {

std::string private_network() {
    static const std::string refused = [] {
        const std::array<std::string, 1> second{"127.0.0.2"};
        return mock::enter_private_network(second);
    }();
    return refused;
}

FramePtr numbered_picture(std::uint64_t number, int width, int height, int bytes_per_pixel) {
    auto frame = std::make_shared<Frame>();
    frame->width = width;
    frame->height = height;
    frame->bytes_per_pixel = bytes_per_pixel;
    frame->pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                         static_cast<std::size_t>(bytes_per_pixel));
    std::uint64_t x = (number + 1) * 0x9e3779b97f4a7c15;
    for (std::byte& pixel : frame->pixels) {  // xorshift: pictures differ in every region
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        pixel = static_cast<std::byte>(x >> 32);
    }
    return frame;
}

bool same_picture(const Frame& a, const Frame& b) {
    return a.width == b.width && a.height == b.height && a.bytes_per_pixel == b.bytes_per_pixel &&
           a.pixels == b.pixels;
}

FramePtr next_frame(Camera& camera) {
    for (int i = 0; i < 50 && !camera.ended(); ++i)
        if (FramePtr frame = camera.read(std::chrono::milliseconds{100})) return frame;
    return nullptr;
}

}  // namespace shaker::test
