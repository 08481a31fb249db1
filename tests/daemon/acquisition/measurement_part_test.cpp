// A measurement takes as much of the streams as its reduction reads, however long the streams are.
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/recording/tables/reduction_tables.hpp"
#include "tests/support/recording/long_run.hpp"

namespace shaker::acquisition {
namespace {

constexpr double everything = 1e300, from_s = 60, to_s = 62;

const test::LongStreams& run() {
    static const test::LongStreams taken = test::make_long_streams({.seconds = 120});
    return taken;
}

TEST(MeasurementPartTest, GivesTheResultsOfTheWholeStreams) {
    const double f = run().header.frequency_hz;
    reduction::Measurement whole = measurement_of(run().streams, f, -everything, everything);
    whole.from_s = from_s;
    whole.to_s = to_s;
    for (reduction::MotionSeries& view : whole.walkers) view.lost = 0;
    for (reduction::MotionSeries& view : whole.bases) view.lost = 0;
    const auto expected = recording::numbers_of(reduce(std::move(whole)));
    reduction::Measurement part = measurement_of(run().streams, f, from_s, to_s);
    for (reduction::MotionSeries& view : part.walkers) view.lost = 0;  // each counts its own span
    for (reduction::MotionSeries& view : part.bases) view.lost = 0;
    const auto numbers = recording::numbers_of(reduce(std::move(part)));
    ASSERT_EQ(numbers.size(), expected.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        EXPECT_EQ(numbers[i].path, expected[i].path);
        if (std::isnan(expected[i].value)) continue;
        EXPECT_EQ(numbers[i].value, expected[i].value) << numbers[i].path;
    }
}

TEST(MeasurementPartTest, HoldsSomeSecondsAroundThePart) {
    const reduction::Measurement m = measurement_of(run().streams, run().header.frequency_hz, from_s, to_s);
    for (const std::vector<double>* t : {&m.accelerometer.t_s, &m.walkers.at(0).t_s, &m.bases.at(0).t_s}) {
        EXPECT_NEAR(t->front(), from_s - 1.2, 0.3);
        EXPECT_NEAR(t->back(), to_s + 1.2, 0.3);
    }
}

}  // namespace
}  // namespace shaker::acquisition
