#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "drivers/errors.hpp"
#include "drivers/hardware/iio/kind.hpp"
#include "drivers/hardware/iio/stream.hpp"
#include "tests/drivers/hardware/iio_bench.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::hardware {
namespace {

TEST(IioStreamTest, NetworkBuffersAllocateOnceAndFree) {
    mock::Iiod iiod{{}};
    const test::PatternFeeder feeder{iiod, 4000};
    iio::IioStream stream{test::settings_for(iiod)};
    stream.start();
    std::span<const std::byte> samples;
    ASSERT_EQ(stream.refill(samples), 0);
    const test::HeapCalls before = test::heap_calls();
    for (int i = 0; i < 10; ++i) ASSERT_EQ(stream.refill(samples), 0);
    EXPECT_EQ(test::heap_calls().taken - before.taken, 10U);
    EXPECT_EQ(test::heap_calls().returned - before.returned, 10U);
    EXPECT_EQ(samples.size(), 64U * 24);
}

TEST(IioStreamTest, ShrinksBufferLongerThanTimeout) {
    const mock::Iiod iiod{{.rate_hz = 125}};
    iio::IioSettings s = test::settings_for(iiod);
    s.timeout_s = 0.4;
    const iio::IioStream stream{s};
    EXPECT_EQ(stream.facts().buffer_samples, 12);  // 0.1 s
    ASSERT_EQ(stream.facts().notes.size(), 1U);
    EXPECT_NE(stream.facts().notes[0].find("buffers of 12 samples"), std::string::npos);
}

TEST(IioStreamTest, RejectsBufferOfReplacedDevice) {
    auto iiod = std::make_unique<mock::Iiod>(mock::IiodDescription{});
    const std::uint16_t port = iiod->port();
    iio::IioStream stream{test::settings_for(*iiod)};
    iiod.reset();
    iiod = std::make_unique<mock::Iiod>(mock::IiodDescription{.mps2_per_count = {1, 1, 1}}, port);
    EXPECT_THROW(stream.start(), DeviceError);
}

TEST(IioDevicesTest, ListsDevicesAndReasonsForMissingOnes) {
    const mock::Iiod iiod{{.label = "base", .serial = "42"}};
    const std::string uri = test::settings_for(iiod).uri;
    std::vector<nlohmann::json> places;
    const auto listed = iio::list_kind({{"--iio", {uri, "ip:127.0.0.1:1"}}});
    for (const ListedDevice& place : listed) places.push_back(nlohmann::json::parse(place.json));
    ASSERT_GE(places.size(), 3U);
    EXPECT_EQ(places.front().at("uri"), "local:");
    const nlohmann::json& mock = places[places.size() - 2];
    EXPECT_EQ(mock.at("uri"), uri);
    ASSERT_EQ(mock.at("devices").size(), 1U) << mock;
    const nlohmann::json& device = mock.at("devices")[0];
    EXPECT_EQ(device.at("name"), "adxl355");
    EXPECT_EQ(device.at("label"), "base");
    EXPECT_EQ(device.at("serial"), "42");
    EXPECT_EQ(device.at("channels").at(0), "accel_x be:s20/32>>12");
    EXPECT_EQ(device.at("rate_hz"), "4000");
    EXPECT_EQ(device.at("rates_hz"), "4000 2000 1000 500 250 125");
    EXPECT_EQ(device.at("trigger"), "adxl355-dev0");
    EXPECT_EQ(device.at("has_stamps"), true);
    EXPECT_EQ(mock.at("triggers"), nlohmann::json::array({"adxl355-dev0"}));
    const std::string text = listed[listed.size() - 2].text;
    EXPECT_TRUE(text.starts_with("  uri = \"" + uri + "\"  device = \"42\"\n      adxl355 (")) << text;
    EXPECT_TRUE(
        text.ends_with(" rate 4000 Hz of 4000 2000 1000 500 250 125; trigger adxl355-dev0 of adxl355-dev0\n"))
        << text;
    const std::string refused = places.back().at("error");
    EXPECT_NE(refused.find("Connection refused"), std::string::npos) << refused;
}

}  // namespace
}  // namespace shaker::hardware
