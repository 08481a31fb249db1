#pragma once
// Small recordings in separate folders: pictures of every kind, tables, descriptions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/errors.hpp"
#include "tests/support/paths.hpp"

namespace shaker::test {

constexpr std::chrono::milliseconds no_wait{0};

/// Text of the refusal of an action; "accepted" without a refusal.
inline std::string refusal(const std::function<void()>& action) {
    try {
        action();
        return "accepted";
    } catch (const InputError& error) {
        return error.what();
    }
}

inline void expect_in(const std::string& message, std::initializer_list<std::string_view> parts) {
    for (const auto part : parts)
        EXPECT_NE(message.find(part), std::string::npos) << "\"" << part << "\" is not in: " << message;
}

/// A temporary folder for one test.
class SessionFolder {
public:
    SessionFolder() {
        const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
        path_ = std::filesystem::path{::testing::TempDir()} /
                (std::string{info->test_suite_name()} + "_" + info->name());
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    ~SessionFolder() { std::filesystem::remove_all(path_); }
    SessionFolder(const SessionFolder&) = delete;
    SessionFolder& operator=(const SessionFolder&) = delete;

    [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    std::filesystem::path write(const std::string& name, const std::string& bytes) const {
        std::filesystem::remove(path_ / name);  // ext4 writes a file that replaces its content to the disk
        std::ofstream{path_ / name, std::ios::binary} << bytes;
        return path_ / name;
    }

private:
    std::filesystem::path path_;
};

/// Grey value of a test picture: every pixel of every picture differs from its neighbours, in all bits.
inline unsigned grey(int picture, int x, int y, unsigned bits) {
    const unsigned value = 40503U * static_cast<unsigned>(1 + x + 37 * y + 1009 * picture);
    return (value >> 3U) & ((1U << bits) - 1U);
}

inline std::string little_endian(std::uint64_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>((value >> (8 * i)) & 0xFFU);
    return text;
}

/// A binary PGM; 16 bits are big endian there.
inline std::string pgm(int picture, int width, int height, unsigned bits) {
    std::string text = "P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n" +
                       std::to_string((1U << bits) - 1U) + "\n";
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const unsigned value = grey(picture, x, y, bits);
            if (bits > 8) text += static_cast<char>(value >> 8U);
            text += static_cast<char>(value & 0xFFU);
        }
    return text;
}

inline unsigned pixel(const Frame& frame, int x, int y) {
    const std::byte* at = frame.view().row(y) + std::ptrdiff_t{x} * frame.bytes_per_pixel;
    std::uint16_t value = 0;
    std::memcpy(&value, at, static_cast<std::size_t>(frame.bytes_per_pixel));
    return value;
}

inline unsigned largest(const Frame& frame) {
    unsigned most = 0;
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) most = std::max(most, pixel(frame, x, y));
    return most;
}

inline void expect_picture(const Frame& frame, int picture, unsigned bits) {
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            ASSERT_EQ(pixel(frame, x, y), grey(picture, x, y, bits))
                << "picture " << picture << " at " << x << ", " << y;
}

inline std::vector<FramePtr> all_frames(Camera& camera) {
    std::vector<FramePtr> frames;
    while (!camera.ended())
        if (auto frame = camera.read(no_wait)) frames.push_back(std::move(frame));
    return frames;
}

/// Folder of the shared data. Empty if it is missing.
inline std::filesystem::path recorded_data() {
    const std::filesystem::path folder = std::filesystem::path{test::source_dir()} / "../shared/data";
    return std::filesystem::is_directory(folder) ? folder : std::filesystem::path{};
}

}  // namespace shaker::test
