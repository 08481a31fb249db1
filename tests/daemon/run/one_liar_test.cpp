// One instrument lies, the base's true motion is the judge: never above 1.25 times its limit, no result from
// a bench whose instruments contradict each other, and no stop of a bench that is honest.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "calibration/accelerometer/sensor_file.hpp"
#include "drivers/errors.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/program.hpp"
#include "tests/support/run/liars.hpp"

namespace shaker::run {
namespace {

using calibration::SensorCalibration;
using test::Judged;
using test::Liar;

struct OneLiarTest : testing::Test {
    ~OneLiarTest() override { std::filesystem::remove_all(folder); }
    const std::filesystem::path folder = test::fresh_folder();
};

void expect_no_harm(const Liar& liar, const Judged& j) {
    EXPECT_EQ(j.beyond_s, 0) << liar.name << ": " << j.largest_mm << " mm, limit " << j.limit_mm;
    if (liar.must_measure()) {
        EXPECT_FALSE(j.trip) << liar.name << ": " << text(*j.trip);
        EXPECT_TRUE(j.measured) << liar.name;
    } else if (liar.must_stop()) {
        EXPECT_TRUE(j.trip) << liar.name << ": measured at " << j.largest_mm << " mm instead of "
                            << j.asked_mm;
        EXPECT_TRUE(!j.trip || (j.trip->cause != safety::Cause::walker_edge &&
                                j.trip->cause != safety::Cause::tracking_lost))
            << liar.name << ": stopped by the walker";
    }
}

TEST_F(OneLiarTest, EachInstrument) {
    for (const Liar& liar : test::liars()) expect_no_harm(liar, test::judge(liar, folder));
}

TEST_F(OneLiarTest, EachInstrumentWithTheResponseOfTheDataSheet) {
    for (const Liar& liar : test::liars()) expect_no_harm(liar, test::judge(liar, folder, false));
}

TEST_F(OneLiarTest, DrawnBySeed) {
    const unsigned seeds = test::nightly() ? 200 : 6;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
        const Liar liar = test::drawn_liar(seed);
        expect_no_harm(liar, test::judge(liar, folder));
    }
}

// Neither few pictures a period nor a motion in the noise of the cameras is a contradiction. Other limits may
// stop such a drive.
TEST_F(OneLiarTest, HonestBenchIsNotStopped) {
    const unsigned seeds = test::nightly() ? 400 : 20;
    std::vector<std::string> refused;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
        const auto [liar, drive] = test::drawn_honest(seed);
        try {
            const Judged j = test::judge(liar, folder, true, drive);
            EXPECT_EQ(j.note, "") << liar.name << ": " << (j.trip ? text(*j.trip) : "");
        } catch (const InputError& e) {  // beyond the bench's limits
            refused.emplace_back(e.what());
        }
    }
    EXPECT_LT(refused.size(), seeds / 2) << refused.back();
}

TEST_F(OneLiarTest, StopNamesBothInstruments) {
    const Judged j = test::judge({"sensor", "[accelerometer]\ngain_x = 0.5\n"}, folder);
    ASSERT_TRUE(j.trip);
    EXPECT_EQ(j.trip->cause, safety::Cause::base_motion) << text(*j.trip);
    EXPECT_NEAR(j.trip->value, 2, 0.2);
    EXPECT_NE(j.note.find("camera \"top\" as by the accelerometer"), std::string::npos) << j.note;
}

// Its file is sealed, but of another sensor or range; the scale of the data sheet would pass.
TEST_F(OneLiarTest, CalibrationThatMissesGravityStopsTheSelfTest) {
    constexpr double nominal = 2 * 78.5 / (1 << 20);
    for (const double size : {0.62, 0.94, 0.97, 1.03, 1.06}) {
        SensorCalibration written{.date = "2026-11-28",
                                  .sensor = "simulated accelerometer",
                                  .nominal_mps2_per_count = {nominal, nominal, nominal}};
        written.fit.gravity = {9.8, 1e-3};
        written.fit.attitudes = 12;
        written.fit.condition = 1.5;
        written.fit.chi2 = 1;
        written.fit.degrees_of_freedom = 10;
        for (std::size_t k = 0; k < 3; ++k) written.fit.gain[k][k] = size * nominal;
        std::ofstream{folder / "acc.toml"} << calibration::calibration_text(written);
        const Judged j =
            test::judge({"calibration", "[accelerometer]\ncalibration = \"acc.toml\"\n"}, folder);
        const bool wrong = std::abs(size - 1) > 0.05;
        EXPECT_EQ(j.trip.has_value(), wrong) << size << (j.trip ? text(*j.trip) : "");
        EXPECT_EQ(j.trip ? j.trip->cause : safety::Cause::gravity, safety::Cause::gravity) << size;
    }
}

}  // namespace
}  // namespace shaker::run
