// What is said about a stored picture: its checksum against another implementation, its seal, its fields.
#include "drivers/replay/frame_record.hpp"

#include <gtest/gtest.h>

#include <boost/crc.hpp>
#include <cstring>

#include "drivers/replay/session_file.hpp"
#include "tests/replay/many_pictures.hpp"

namespace shaker::session_test {
namespace {

std::uint32_t by_boost(std::span<const std::byte> bytes) {
    boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
    crc.process_bytes(bytes.data(), bytes.size());
    return crc.checksum();
}

TEST(FrameRecordTest, ThePixelsChecksumIsThatOfAnotherImplementation) {
    for (int width = 1; width < 80; ++width) {
        const Frame frame = numbered(static_cast<std::uint64_t>(width), {width, 3, 1});
        EXPECT_EQ(record_of(frame, 1).pixels_crc32c, by_boost(frame.pixels)) << width;
    }
    Frame digits;
    for (const char c : {'1', '2', '3', '4', '5', '6', '7', '8', '9'})
        digits.pixels.push_back(static_cast<std::byte>(c));
    EXPECT_EQ(record_of(digits, 1).pixels_crc32c, 0xE3069283U) << "the check value of CRC-32C";
}

TEST(FrameRecordTest, ASealIsBrokenByEveryBitAndByAnotherNumber) {
    const FrameRecord record = record_of(numbered(77, {5, 4, 2}), 77);
    EXPECT_EQ(fault_of(record, 77), FrameFault::none);
    EXPECT_EQ(fault_of(record, 76), FrameFault::bad_record);
    EXPECT_EQ(fault_of(FrameRecord{}, 77), FrameFault::no_record);
    for (std::size_t bit = 0; bit < 8 * sizeof record; ++bit) {
        std::array<unsigned char, sizeof record> bytes{};
        std::memcpy(bytes.data(), &record, sizeof record);
        bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ (1U << bit % 8));
        FrameRecord changed;
        std::memcpy(&changed, bytes.data(), sizeof changed);
        EXPECT_EQ(fault_of(changed, 77), FrameFault::bad_record) << "bit " << bit;
    }
}

TEST(FrameRecordTest, WhatIsNotKnownStaysNotKnown) {
    const FrameShape shape{5, 4, 2};
    Frame frame = numbered(1, shape);
    frame.stamp.reset();
    frame.mid_exposure.reset();
    const FrameRecord record = record_of(frame, 1);
    EXPECT_EQ(record.stamp, no_stamp);
    EXPECT_TRUE(std::isnan(record.mid_exposure));
    Frame back = frame_of(record, shape);
    back.pixels = frame.pixels;
    expect_same(back, frame, 1);
}

}  // namespace
}  // namespace shaker::session_test
