// Records of stored pictures: checksum against another implementation, seal, fields.
#include "drivers/recorded/pictures/picture_record.hpp"

#include <gtest/gtest.h>

#include <boost/crc.hpp>
#include <cstring>

#include "drivers/recorded/recording_file.hpp"
#include "tests/support/recording/many_pictures.hpp"

namespace shaker::recorded {

using namespace test;
namespace {

std::uint32_t by_boost(std::span<const std::byte> bytes) {
    boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
    crc.process_bytes(bytes.data(), bytes.size());
    return crc.checksum();
}

TEST(PictureRecordTest, ChecksumMatchesAnotherImplementation) {
    for (int width = 1; width < 80; ++width) {
        const Frame frame = numbered(static_cast<std::uint64_t>(width), {width, 3, 1});
        EXPECT_EQ(pictures::record_of(frame, 1).pixels_crc32c, by_boost(frame.pixels)) << width;
    }
    Frame digits;
    for (const char c : {'1', '2', '3', '4', '5', '6', '7', '8', '9'})
        digits.pixels.push_back(static_cast<std::byte>(c));
    EXPECT_EQ(pictures::record_of(digits, 1).pixels_crc32c, 0xE3069283U) << "the check value of CRC-32C";
}

TEST(PictureRecordTest, DetectsAnyChangedBitOrNumber) {
    const pictures::PictureRecord record = pictures::record_of(numbered(77, {5, 4, 2}), 77);
    EXPECT_EQ(fault_of(record, 77), pictures::PictureFault::none);
    EXPECT_EQ(fault_of(record, 76), pictures::PictureFault::bad_record);
    EXPECT_EQ(fault_of(pictures::PictureRecord{}, 77), pictures::PictureFault::no_record);
    for (std::size_t bit = 0; bit < 8 * sizeof record; ++bit) {
        std::array<unsigned char, sizeof record> bytes{};
        std::memcpy(bytes.data(), &record, sizeof record);
        bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ (1U << bit % 8));
        pictures::PictureRecord changed;
        std::memcpy(&changed, bytes.data(), sizeof changed);
        EXPECT_EQ(fault_of(changed, 77), pictures::PictureFault::bad_record) << "bit " << bit;
    }
}

TEST(PictureRecordTest, KeepsUnknownValuesUnknown) {
    const pictures::PictureShape shape{5, 4, 2};
    Frame frame = numbered(1, shape);
    frame.stamp.reset();
    frame.mid_exposure.reset();
    const pictures::PictureRecord record = pictures::record_of(frame, 1);
    EXPECT_EQ(record.stamp, pictures::no_stamp);
    EXPECT_TRUE(std::isnan(record.mid_exposure));
    Frame back = frame_of(record, shape);
    back.pixels = frame.pixels;
    expect_same(back, frame, 1);
}

}  // namespace
}  // namespace shaker::recorded
