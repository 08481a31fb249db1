// A simulated bench with everything wrong by 1 to 3 %: scales, lenses, gains, axes and tilt. Uncalibrated it
// alarms; calibrated by the two commands it measures the truth.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

using nlohmann::json;
using test::Outcome;
using test::shakerd;

const std::string tilt = "tilt_deg = 0.5\n";
const std::string sensor =
    "[accelerometer]\ngain_x = 1.015\ngain_y = 0.98\ngain_z = 1.012\ncross_xy = 0.02\noffset_x_mps2 = 0.2\n"
    "offset_z_mps2 = -0.15\n";
const std::string size = "width_px = 480\nheight_px = 200\nframe_rate_hz = 500\n";

struct WrongCamera {
    std::string name, keys;
};
const std::array cameras{
    WrongCamera{"top", size + "mm_per_px = 0.4\ntrue_mm_per_px = 0.41\ntrue_distance_mm = 610\n"
                              "true_k1 = -0.3\ntrue_tilt_x_deg = 2\n"},
    WrongCamera{"side", size + "mm_per_px = 0.4\ntrue_mm_per_px = 0.393\ntrue_distance_mm = 590\n"
                               "true_k1 = -0.2\ntrue_tilt_x_deg = -1.5\n"}};

struct WrongBenchTest : testing::Test {
    ~WrongBenchTest() override { std::filesystem::remove_all(folder); }

    /// Both cameras with their positions, one table each.
    template <class Keys>
    [[nodiscard]] json measure(const std::string& others, Keys keys) const {
        std::string scene = tilt;
        for (const WrongCamera& c : cameras) scene += "[" + c.name + "]\npositions = 1\n" + keys(c);
        std::ofstream{folder / "bench.toml"} << scene + others;
        const Outcome o = shakerd(
            "run --scene bench.toml --gamma 0.7g --periods 60 --no-identify --open-loop --json", folder);
        EXPECT_EQ(o.status, 0) << o.err;
        return json::parse(o.out);
    }
    void calibrate(const std::string& scene, const std::string& arguments) const {
        std::ofstream{folder / "calibrated.toml"} << scene;
        const Outcome o = shakerd("calibrate " + arguments + " --scene calibrated.toml", folder);
        ASSERT_EQ(o.status, 0) << o.err << o.out;
    }
    static bool alarms(const json& results) {
        return std::ranges::any_of(results.at("notes"), [](const std::string& note) {
            return note.find("by camera") != std::string::npos;
        });
    }

    std::filesystem::path folder = test::fresh_folder();
};

TEST_F(WrongBenchTest, IsRightWithinATenthOfAPercentOnceItIsCalibrated) {
    const json truth = measure("", [](const WrongCamera&) { return size; });
    EXPECT_FALSE(alarms(truth)) << truth.at("notes").dump(1);
    const json wrong = measure(sensor, [](const WrongCamera& c) { return c.keys; });
    EXPECT_TRUE(alarms(wrong)) << wrong.at("notes").dump(1);
    EXPECT_GT(std::abs(wrong.at("gamma_mps2").get<double>() / truth.at("gamma_mps2").get<double>() - 1),
              0.01);

    calibrate(sensor +
                  "attitudes = '+x -x +y -y +z -z +x+y +x-y -x+y -x-y +x+z +x-z -x+z -x-z +y+z +y-z "
                  "-y+z -y-z'\n",
              "accelerometer --g 9.8m/s^2 -o sensor.toml");
    for (const WrongCamera& c : cameras)
        calibrate("[" + c.name + "]\n" + c.keys +
                      "boards = '-35 0 2 0  0 5 -10 0  35 -5 8 0  -20 3 4 12'\nboard_s = 4\n",
                  "camera --camera " + c.name +
                      " --pictures 3 --raised-by 12mm --hold 1s --square 10mm --board-error 1e-4 "
                      "--height-error 0.01mm -o " +
                      c.name + ".toml");
    const json right = measure(sensor + "calibration = 'sensor.toml'\n", [](const WrongCamera& c) {
        return c.keys + "calibration = '" + c.name + ".toml'\n";
    });
    EXPECT_FALSE(alarms(right)) << right.at("notes").dump(1);
    for (const auto& [name, unit] : {std::pair{"v_D", "_mps"}, {"gamma", "_mps2"}}) {
        const auto of = [&, n = std::string{name}, u = std::string{unit}](const json& r, const char* part) {
            return r.at(n + part + u).get<double>();
        };
        const double value = of(right, ""), is = of(truth, "");
        const double error = std::hypot(of(right, "_se"), of(right, "_systematic"), of(truth, "_se"));
        EXPECT_NEAR(value / is, 1, 1e-3) << name;
        EXPECT_LT(std::abs(value - is), 2 * error) << name;
        std::printf(
            "%s: uncalibrated %+.3f %%, calibrated %+.4f %% from the truth; stated error %.4f %%, "
            "%.4f %% of it systematic\n",
            name, 100 * (of(wrong, "") / is - 1), 100 * (value / is - 1),
            100 * std::hypot(of(right, "_se"), of(right, "_systematic")) / is,
            100 * of(right, "_systematic") / is);
    }
}

}  // namespace
}  // namespace shaker::commands
