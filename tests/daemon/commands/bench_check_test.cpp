// A simulated bench with wrong scales, gains and a tilt: the alarm before its calibration, the results after
// it.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

using nlohmann::json;
using test::Outcome;
using test::shakerd;

const std::string bench = "tilt_deg = 0.2\n[top]\npositions = 1\n[side]\npositions = 1\n";
const std::string wrong_sensor =
    "[accelerometer]\ngain_x = 1.0085\ngain_y = 0.985\ngain_z = 1.01\ncross_xy = 0.006\noffset_x_mps2 = 0.2\n"
    "offset_z_mps2 = -0.15\n";

struct CheckedBenchTest : testing::Test {
    ~CheckedBenchTest() override { std::filesystem::remove_all(folder); }

    void write(const std::string& name, const std::string& text) const {
        std::ofstream{folder / name} << text;
    }
    [[nodiscard]] json run(const std::string& scene, const std::string& arguments = "") const {
        write("scene.toml", scene);
        const Outcome o = shakerd(
            "run --scene scene.toml --gamma 0.7g --periods 40 --no-identify --open-loop "
            "--json " +
                arguments,
            folder);
        EXPECT_EQ(o.status, 0) << o.err;
        return json::parse(o.out);
    }
    [[nodiscard]] json replayed(const std::string& settings) const {
        const Outcome o = shakerd("replay --from tracks --json run.nxs" + settings, folder);
        EXPECT_EQ(o.status, 0) << o.err;
        return json::parse(o.out);
    }
    static std::size_t notes_with(const json& results, const std::string& words) {
        std::size_t found = 0;
        for (const std::string note : results.at("notes")) found += note.find(words) != std::string::npos;
        return found;
    }
    /// Within 0.1 % of the truth, and within twice its errors.
    static void expect_true(const json& results, const std::string& name, const std::string& unit,
                            double truth) {
        const double value = results.at(name + unit), error = results.at(name + "_se" + unit),
                     systematic = results.at(name + "_systematic" + unit);
        EXPECT_NEAR(value / truth, 1, 1e-3) << name;
        EXPECT_LT(std::abs(value - truth), 2 * std::hypot(error, systematic)) << name;
        std::printf("%s: %+.4f %% from the truth, errors %.4f %% and %.4f %% systematic\n", name.c_str(),
                    100 * (value / truth - 1), 100 * error / truth, 100 * systematic / truth);
    }

    std::filesystem::path folder = test::fresh_folder();
};

TEST_F(CheckedBenchTest, AlarmsUntilItIsCalibrated) {
    const json perfect = run(bench);
    EXPECT_EQ(notes_with(perfect, "by camera"), 0U) << perfect.at("notes").dump(1);
    const json wrong = run(bench + wrong_sensor);
    EXPECT_EQ(notes_with(wrong, "by camera"), 2U) << wrong.at("notes").dump(1);
    EXPECT_EQ(notes_with(wrong, "if the accelerometer has no offset"), 1U) << wrong.at("notes").dump(1);
    EXPECT_NEAR(wrong.at("bench_check").at("ratio").get<double>(), 1 / 1.0085, 2e-3);
    EXPECT_TRUE(wrong.at("gamma_systematic_mps2").is_null());
    EXPECT_GT(std::abs(wrong.at("gamma_mps2").get<double>() / perfect.at("gamma_mps2").get<double>() - 1),
              0.007);

    write("turned.toml",
          bench + wrong_sensor +
              "attitudes = '+x -x +y -y +z -z +x+y +x-y -x+y -x-y +x+z +x-z -x+z -x-z +y+z +y-z "
              "-y+z -y-z'\n");
    const Outcome o = shakerd("calibrate accelerometer --scene turned.toml --g 9.8m/s^2 -o cal.toml", folder);
    ASSERT_EQ(o.status, 0) << o.err;
    const json calibrated = run(bench + wrong_sensor + "calibration = 'cal.toml'\n", "-o run.nxs");
    EXPECT_EQ(notes_with(calibrated, "by camera"), 0U) << calibrated.at("notes").dump(1);
    EXPECT_EQ(notes_with(calibrated, "gravity shows a tilt of +3."), 1U) << calibrated.at("notes").dump(1);
    const json& check = calibrated.at("bench_check");
    EXPECT_NEAR(check.at("tilt_rad").get<double>(), 0.2 * std::numbers::pi / 180,
                3 * check.at("tilt_se_rad").get<double>());
    expect_true(calibrated, "gamma", "_mps2", perfect.at("gamma_mps2"));

    const json scaled = replayed(" --set top.mm_per_px=0.402 --set side.mm_per_px=0.402");
    EXPECT_EQ(notes_with(scaled, "camera scale (the accelerometer is calibrated)"), 2U)
        << scaled.at("notes").dump(1);
    const json all = replayed(" --set top.scale_error=0.0005 --set side.scale_error=0.0005");
    EXPECT_EQ(notes_with(all, "by camera"), 0U) << all.at("notes").dump(1);
    expect_true(all, "v_D", "_mps", perfect.at("v_D_mps"));
    const Outcome same = shakerd("replay run.nxs", folder);
    EXPECT_NE(same.out.find("replay: identical"), std::string::npos) << same.out;
    EXPECT_NE(same.out.find("tilt"), std::string::npos) << same.out;
    const Outcome list = shakerd("list run.nxs", folder);
    EXPECT_NE(list.out.find("camera/accelerometer "), std::string::npos) << list.out;
}

}  // namespace
}  // namespace shaker::commands
