#include <gtest/gtest.h>
#include <iio.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "drivers/hardware/iio/sample.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::hardware {
namespace {

struct Scene {
    std::unique_ptr<iio_context, void (*)(iio_context*)> context{nullptr, iio_context_destroy};
    const iio_device* device = nullptr;
    [[nodiscard]] const iio_channel* channel(unsigned i) const { return iio_device_get_channel(device, i); }
};

/// A libiio device with channels c0, c1, ... of these formats.
Scene scene(const std::vector<std::string>& formats) {
    std::string xml = R"(<?xml version="1.0"?><context name="x"><device id="iio:device0" name="d">)";
    for (std::size_t i = 0; i < formats.size(); ++i)
        xml += "<channel id=\"c" + std::to_string(i) + "\" type=\"input\"><scan-element index=\"" +
               std::to_string(i) + "\" format=\"" + formats[i] + "\" /></channel>";
    xml += "</device></context>";
    Scene s;
    s.context.reset(iio_create_xml_context_mem(xml.data(), xml.size()));
    s.device = s.context ? iio_context_get_device(s.context.get(), 0) : nullptr;
    return s;
}

iio::IioFormat format_of(const iio_channel* channel) {
    const iio_data_format* f = iio_channel_get_data_format(channel);
    return {f->bits, f->length, f->shift, f->is_signed, f->is_be};
}

TEST(IioSampleTest, UnpacksEveryFormatLikeLibiio) {
    const std::vector<std::string> formats{
        "be:s20/32&gt;&gt;12", "le:s20/32&gt;&gt;4", "be:u20/32&gt;&gt;0", "le:s16/16&gt;&gt;0",
        "be:s12/16&gt;&gt;4",  "le:u12/16&gt;&gt;2", "le:s8/8&gt;&gt;0",   "le:u7/8&gt;&gt;1",
        "le:s32/32&gt;&gt;0",  "be:s24/32&gt;&gt;8", "le:s64/64&gt;&gt;0", "be:s48/64&gt;&gt;16",
        "le:S32/32&gt;&gt;0",  "be:u31/32&gt;&gt;1", "be:s64/64&gt;&gt;0", "le:u16/32&gt;&gt;16"};
    const Scene s = scene(formats);
    ASSERT_NE(s.device, nullptr);
    std::mt19937_64 random{7};
    for (unsigned i = 0; i < formats.size(); ++i) {
        const iio_channel* channel = s.channel(i);
        const iio::IioField field{format_of(channel), 0};
        for (int round = 0; round < 1000; ++round) {
            const std::uint64_t bytes = round == 0 ? 0 : round == 1 ? ~std::uint64_t{0} : random();
            std::int64_t theirs = 0;
            iio_channel_convert(channel, &theirs, &bytes);
            // libiio writes all bytes of the storage: extend the sign by the format.
            const unsigned above = 64 - field.format.storage_bits;
            const std::uint64_t word = static_cast<std::uint64_t>(theirs) << above;
            theirs = field.format.is_signed ? static_cast<std::int64_t>(word) >> above
                                            : static_cast<std::int64_t>(word >> above);
            const auto* raw = reinterpret_cast<const std::byte*>(&bytes);
            ASSERT_EQ(unpack({raw, 8}, field), theirs) << formats[i] << " of " << std::hex << bytes;
        }
    }
}

TEST(IioSampleTest, LayoutMatchesTheKernels) {
    const iio::IioFormat axis{20, 32, 12, true, true}, stamp{64, 64, 0, true, false};
    const auto scan = lay_out_scan({{{axis, 0}, {axis, 1}, {axis, 2}}}, iio::IioChannel{stamp, 3});
    EXPECT_EQ(scan.axes[2].offset, 8U);
    EXPECT_EQ(scan.stamp->offset, 16U);  // after 4 bytes of padding
    EXPECT_EQ(scan.size, 24U);
    EXPECT_EQ(iio::lay_out_scan({{{axis, 0}, {axis, 1}, {axis, 2}}}, {}).size, 12U);
    const iio::IioFormat small{12, 16, 4, true, true};
    EXPECT_EQ(lay_out_scan({{{small, 0}, {small, 1}, {small, 2}}}, iio::IioChannel{stamp, 3}).size, 16U);
}

TEST(IioSampleTest, OrderFollowsIndexNotAxes) {
    const iio::IioFormat wide{20, 32, 12, true, true}, narrow{16, 16, 0, true, false},
        stamp{64, 64, 0, true, false};
    const auto scan = lay_out_scan({{{narrow, 7}, {wide, 2}, {narrow, 9}}}, iio::IioChannel{stamp, 1});
    EXPECT_EQ(scan.stamp->offset, 0U);
    EXPECT_EQ(scan.axes[1].offset, 8U);
    EXPECT_EQ(scan.axes[0].offset, 12U);
    EXPECT_EQ(scan.axes[2].offset, 14U);
    EXPECT_EQ(scan.size, 16U);
}

TEST(IioSampleTest, LimitsFollowTheBits) {
    EXPECT_EQ(iio::limits_of({20, 32, 12, true, true}), (std::array<std::int64_t, 2>{-524288, 524287}));
    EXPECT_EQ(iio::limits_of({12, 16, 0, false, false}), (std::array<std::int64_t, 2>{0, 4095}));
    EXPECT_TRUE(iio::fits_counts({32, 32, 0, true, false}));
    EXPECT_FALSE(iio::fits_counts({32, 32, 0, false, false}));
    EXPECT_FALSE(iio::fits_counts({40, 64, 0, true, false}));
    EXPECT_FALSE(iio::fits_counts({20, 32, 16, true, false}));
}

TEST(IioSampleTest, UnpackingDoesNotAllocate) {
    const iio::IioField field{{20, 32, 12, true, true}, 4};
    const std::array<std::byte, 8> sample{};
    const test::NoAlloc guard;
    EXPECT_EQ(unpack(sample, field), 0);
}

}  // namespace
}  // namespace shaker::hardware
