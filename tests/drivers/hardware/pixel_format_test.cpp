#include <gtest/gtest.h>

#include <cstring>
#include <initializer_list>
#include <vector>

#include "drivers/hardware/genicam/settings.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::hardware {
namespace {

std::vector<std::byte> bytes(std::initializer_list<int> values) {
    std::vector<std::byte> result;
    for (const int value : values) result.push_back(static_cast<std::byte>(value));
    return result;
}

std::vector<int> unpacked(std::string_view name, const std::vector<std::byte>& wire, std::size_t pixels) {
    const genicam::PixelFormat* format = genicam::find_pixel_format(name);
    std::vector<std::byte> out(2 * pixels);
    {
        const test::NoAlloc guard;
        unpack_pixels(*format, wire, out);
    }
    std::vector<int> codes;
    for (std::size_t i = 0; i < pixels; ++i) {
        std::uint16_t code = 0;
        std::memcpy(&code, &out[2 * i], 2);
        codes.push_back(code);
    }
    return codes;
}

// The bytes are worked out by hand from the layouts in GigE Vision 1.2 (Packed) and in the Pixel Format
// Naming Convention (p).
TEST(PixelFormatTest, UnpacksTwelveBitsOfGigEVision) {
    EXPECT_EQ(unpacked("Mono12Packed", bytes({0xab, 0x3c, 0x12}), 2), (std::vector<int>{0xabc, 0x123}));
}

TEST(PixelFormatTest, UnpacksTenBitsOfGigEVision) {
    // 0x2ad = 10101011 01, 0x04a = 00010010 10: bits 0-1 and 4-5 of the middle byte are the lower ones.
    EXPECT_EQ(unpacked("Mono10Packed", bytes({0xab, 0x21, 0x12}), 2), (std::vector<int>{0x2ad, 0x04a}));
}

TEST(PixelFormatTest, UnpacksTwelveBitsWithoutGaps) {
    EXPECT_EQ(unpacked("Mono12p", bytes({0xbc, 0x3a, 0x12}), 2), (std::vector<int>{0xabc, 0x123}));
}

TEST(PixelFormatTest, UnpacksTenBitsWithoutGaps) {
    // Codes 1, 2, 4, 1023: bit k of pixel i is bit 10 i + k of the stream.
    EXPECT_EQ(unpacked("Mono10p", bytes({0x01, 0x08, 0x40, 0xc0, 0xff}), 4),
              (std::vector<int>{1, 2, 4, 1023}));
}

TEST(PixelFormatTest, AnOddNumberOfPixelsLosesNone) {
    EXPECT_EQ(unpacked("Mono12Packed", bytes({0xab, 0x3c, 0x12, 0xff, 0x0f}), 3),
              (std::vector<int>{0xabc, 0x123, 0xfff}));
    EXPECT_EQ(unpacked("Mono12p", bytes({0xbc, 0x3a, 0x12, 0xff, 0x0f}), 3),
              (std::vector<int>{0xabc, 0x123, 0xfff}));
}

TEST(PixelFormatTest, PlainWordsAreNotScaled) {
    EXPECT_EQ(unpacked("Mono10", bytes({0xff, 0x03, 0x01, 0x00}), 2), (std::vector<int>{1023, 1}));
}

TEST(PixelFormatTest, BytesOnTheWireFollowTheFormatsOwnCode) {
    const auto wire = [](std::string_view name, std::size_t pixels) {
        return genicam::find_pixel_format(name)->wire_bytes(pixels);
    };
    EXPECT_EQ(wire("Mono8", 10), 10u);
    EXPECT_EQ(wire("Mono10", 10), 20u);
    EXPECT_EQ(wire("Mono10Packed", 10), 15u);
    EXPECT_EQ(wire("Mono10p", 10), 13u);  // 12.5
    EXPECT_EQ(wire("Mono12Packed", 10), 15u);
    EXPECT_EQ(wire("Mono12p", 10), 15u);
    EXPECT_EQ(wire("Mono16", 10), 20u);
    EXPECT_EQ(genicam::find_pixel_format("RGB8"), nullptr);
}

}  // namespace
}  // namespace shaker::hardware
