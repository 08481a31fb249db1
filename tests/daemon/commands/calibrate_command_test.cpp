#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "calibration/accelerometer/sensor_file.hpp"
#include "daemon/commands/calibrate/held_records.hpp"
#include "drivers/errors.hpp"
#include "tests/support/calibration/tumbled_sensor.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

using nlohmann::json;
using test::Outcome;
using test::TumbledSensor;

struct CalibrateCommandTest : testing::Test {
    ~CalibrateCommandTest() override { std::filesystem::remove_all(folder); }

    void write(const std::string& name, const std::string& text) const {
        std::ofstream{folder / name} << text;
    }
    [[nodiscard]] std::string read(const std::string& name) const {
        std::ifstream in{folder / name};
        return {std::istreambuf_iterator<char>{in}, {}};
    }
    template <class Names>
    [[nodiscard]] std::string table(const Names& names) {
        std::string text = held_header({.sensor = "other recorder"});
        for (const std::string_view name : names) text += held_rows(std::string{name}, sensor.record(name));
        return text;
    }
    [[nodiscard]] Outcome calibrate(const std::string& arguments) const {
        return test::shakerd("calibrate accelerometer " + arguments, folder);
    }
    void expect_refused(const std::string& arguments, const std::string& words) const {
        const Outcome o = calibrate(arguments);
        EXPECT_EQ(o.status, 2) << arguments;
        EXPECT_NE(o.err.find(words), std::string::npos) << o.err;
        EXPECT_FALSE(std::filesystem::exists(folder / "cal.toml")) << arguments;
    }

    std::filesystem::path folder = test::fresh_folder();
    TumbledSensor sensor{};
};

TEST_F(CalibrateCommandTest, FitsTheRecordsOfFiles) {
    write("held.csv", table(standard_attitudes));
    const Outcome o = calibrate("--from held.csv --g 9.8123m/s^2 -o cal.toml --json");
    ASSERT_EQ(o.status, 0) << o.err;
    const json j = json::parse(o.out);
    const calibration::SensorCalibration c = calibration::parse_calibration(read("cal.toml"), "cal.toml");
    EXPECT_EQ(c.sensor, "other recorder");
    EXPECT_EQ(c.fit.attitudes, 18);
    EXPECT_EQ(j.at("gain_mps2_per_count")[1][2].get<double>(), c.fit.gain[1][2]);
    EXPECT_LT(j.at("gain_errors_relative")[0].get<double>(), 5e-5);
    EXPECT_NEAR(c.fit.gain[0][0] / sensor.mps2_per_count * 1.021, 1, 1e-3);
    EXPECT_TRUE(j.at("findings").empty());
}

TEST_F(CalibrateCommandTest, TakesSeveralFilesAndGravityOfAPlace) {
    for (const std::string_view name : standard_attitudes)
        write(std::string{name} + ".csv", table(std::array{name}));
    std::string files;
    for (const std::string_view name : standard_attitudes) files += " ./" + std::string{name} + ".csv";
    const Outcome o = calibrate("--latitude 52.1deg --height 80m -o cal.toml --from" + files);
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.out.find("18 attitudes, g = 9.81232 +- 0.00030 m/s^2"), std::string::npos) << o.out;
    EXPECT_NE(o.out.find("[accelerometer] calibration = \"cal.toml\""), std::string::npos) << o.out;
}

TEST_F(CalibrateCommandTest, NamesSwappedAxes) {
    std::swap(sensor.gain[1], sensor.gain[2]);
    std::swap(sensor.offset[1], sensor.offset[2]);
    write("held.csv", table(standard_attitudes));
    const Outcome o = calibrate("--from held.csv --g 9.8123m/s^2 -o cal.toml");
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.out.find("note: axes y and z are swapped"), std::string::npos) << o.out;
}

TEST_F(CalibrateCommandTest, RefusesBadRecordsByName) {
    write("faces.csv", table(std::array<std::string_view, 6>{"+x", "-x", "+y", "-y", "+z", "-z"}));
    expect_refused("--from faces.csv --g 9.81m/s^2 -o cal.toml", "hold the sensor also at +x+y, +x-y,");
    write("moved.csv", table(standard_attitudes) + held_rows("+x-y+z", sensor.record("+x-y+z", 3)));
    expect_refused("--from moved.csv --g 9.81m/s^2 -o cal.toml", "attitude 19 (+x-y+z): the sensor moved:");
    write("bad.csv", "attitude,x,y,z\n+x,1,2,3\n+x,1,2.5,3\n");
    expect_refused("--from bad.csv --g 9.81m/s^2 -o cal.toml",
                   "bad.csv:3: expected counts, a whole number, got \"2.5,3\"");
    write("bad.csv", "attitude,x,y,z\nup,1,2,3\n");
    expect_refused("--from bad.csv --g 9.81m/s^2 -o cal.toml", "bad.csv:2: \"up\" is not an attitude");
    write("bad.csv", "x,y,z\n1,2,3\n");
    expect_refused("--from bad.csv --g 9.81m/s^2 -o cal.toml",
                   "bad.csv:1: expected the header \"attitude,x,y,z\"");
    expect_refused("--from none.csv --g 9.81m/s^2 -o cal.toml", "none.csv: cannot be read: No such file");
}

TEST_F(CalibrateCommandTest, NeedsGravityAndANewFile) {
    write("held.csv", table(standard_attitudes));
    expect_refused("--from held.csv -o cal.toml", "expected either --g");
    expect_refused("--from held.csv --g 9.81m/s^2 --latitude 52deg -o cal.toml", "expected either --g");
    write("old.toml", "kept");
    expect_refused("--from held.csv --g 9.8123m/s^2 -o old.toml", "old.toml: exists and is not overwritten");
    EXPECT_EQ(read("old.toml"), "kept");
}

// A simulated bench whose sensor is wrong in gains, cross axes and offsets is calibrated by hand-held
// attitudes, and then measures the gamma that its cameras see.
TEST_F(CalibrateCommandTest, CalibratesTheSimulatedBenchLive) {
    const std::string wrong =
        "[top]\npositions = 1\nframe_rate_hz = 100\n[side]\npositions = 1\nframe_rate_hz = 100\n"
        "[accelerometer]\ngain_x = 1.02\ngain_y = 0.985\ngain_z = 1.01\ncross_xy = 0.012\ncross_zx = -0.01\n"
        "offset_x_mps2 = 0.2\noffset_z_mps2 = -0.15\n";
    write("turned.toml", wrong +
                             "attitudes = '+x -x +y -y +z -z +x+y +x-y -x+y -x-y +x+z +x-z -x+z -x-z +y+z "
                             "+y-z -y+z -y-z'\n");
    const Outcome live = calibrate("--scene turned.toml --g 9.8m/s^2 -o cal.toml");
    ASSERT_EQ(live.status, 0) << live.err << live.out;
    EXPECT_NE(live.out.find("-y-z: held, 18 of 18; condition number"), std::string::npos) << live.out;
    const auto fit = calibration::parse_calibration(read("cal.toml"), "cal.toml").fit;
    const double lsb = 78.5 / 524288;
    EXPECT_NEAR(fit.gain[1][1] / lsb, 1 / 0.985, 2e-4);
    EXPECT_NEAR(fit.offset_counts[2] * lsb, 0.15, 1e-3);
    const Outcome again = calibrate("--from cal.csv --g 9.8m/s^2 -o again.toml");
    ASSERT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(calibration::parse_calibration(read("again.toml"), "again.toml").fit.gain, fit.gain);

    const auto gamma = [&](const std::string& scene) {
        write("bench.toml", scene);
        const Outcome o = test::shakerd(
            "run --scene bench.toml --gamma 0.5g --periods 40 --no-identify --open-loop --json", folder);
        EXPECT_EQ(o.status, 0) << o.err;
        return json::parse(o.out).at("gamma_mps2").get<double>();
    };
    const std::string cameras = wrong.substr(0, wrong.find("[accel"));
    const double truth = gamma(cameras);
    EXPECT_NEAR(gamma(wrong) / truth, 1.02, 2e-3);
    EXPECT_NEAR(gamma(wrong + "calibration = 'cal.toml'\n") / truth, 1, 2e-4);
}

TEST_F(CalibrateCommandTest, SceneWithoutAttitudesIsRefused) {
    expect_refused("--g 9.8m/s^2 -o cal.toml", "the scene holds the sensor in no attitudes");
}

}  // namespace
}  // namespace shaker::commands
