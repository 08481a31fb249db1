#include <gtest/gtest.h>

#include "calibration/accelerometer/attitudes.hpp"
#include "tests/support/calibration/tumbled_sensor.hpp"

namespace shaker::calibration {
namespace {

using test::TumbledSensor;

// Names of the directions of the attitudes that are found in this stream.
std::vector<std::string_view> found_in(const std::vector<Counts>& stream, const TumbledSensor& sensor) {
    HeldFinder finder{sensor.rate_hz, sensor.hold_s, sensor.nominal(), sensor.gravity};
    std::vector<std::string_view> names;
    for (const Counts& sample : stream)
        if (const auto attitude = finder.add(sample)) names.push_back(nearest_attitude(attitude->mean));
    return names;
}

struct HeldFinderTest : testing::Test {
    void hold(std::string_view name, double turn = 0) {
        const std::vector<Counts> record = sensor.record(name, turn);
        stream.insert(stream.end(), record.begin(), record.end());
    }
    TumbledSensor sensor{};
    std::vector<Counts> stream{};
};

TEST_F(HeldFinderTest, FindsEachAttitudeOnceButNotTheFirst) {
    for (const char* name : {"+z", "+x", "+x", "+x", "-x", "-x", "+x", "+x"}) hold(name);
    EXPECT_EQ(found_in(stream, sensor), (std::vector<std::string_view>{"+x", "-x", "+x"}));
}

TEST_F(HeldFinderTest, WaitsUntilTheSensorIsAtRest) {
    for (const char* name : {"+z", "+x"}) hold(name, 40);
    EXPECT_TRUE(found_in(stream, sensor).empty());
    hold("+z");
    hold("+z");
    hold("+y");
    hold("+y");
    EXPECT_EQ(found_in(stream, sensor), (std::vector<std::string_view>{"+y"}));
}

TEST_F(HeldFinderTest, MissingSamplesBeginARecordAgain) {
    HeldFinder finder{sensor.rate_hz, sensor.hold_s, sensor.nominal(), sensor.gravity};
    hold("+z");
    hold("+x");
    for (std::size_t i = 0; i < stream.size(); ++i) {
        if (i == stream.size() - 10) finder.begin_again();
        EXPECT_FALSE(finder.add(stream[i]));
    }
}

TEST_F(HeldFinderTest, KeepsTheSamplesOfTheAttitude) {
    HeldFinder finder{sensor.rate_hz, sensor.hold_s, sensor.nominal(), sensor.gravity};
    hold("+z");
    hold("+x");
    hold("+x");
    for (const Counts& sample : stream)
        if (const auto attitude = finder.add(sample)) {
            ASSERT_EQ(finder.record().size(), 800U);
            EXPECT_EQ(attitude_of("", finder.record()).mean, attitude->mean);
            return;
        }
    FAIL() << "no attitude was found";
}

}  // namespace
}  // namespace shaker::calibration
