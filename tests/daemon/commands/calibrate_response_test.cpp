// The response of the accelerometer as a user measures it: its drives, their fit, and a bench that has it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

using nlohmann::json;
using test::Outcome;

struct CalibrateResponseTest : testing::Test {
    ~CalibrateResponseTest() override { std::filesystem::remove_all(folder); }
    void write(const std::string& name, const std::string& text) const {
        std::ofstream{folder / name} << text;
    }
    [[nodiscard]] Outcome calibrate(const std::string& arguments) const {
        return test::shakerd("calibrate response " + arguments, folder);
    }
    void expect_refused(const std::string& arguments, const std::string& words) const {
        const Outcome o = calibrate(arguments);
        EXPECT_EQ(o.status, 2) << arguments;
        EXPECT_NE(o.err.find(words), std::string::npos) << o.err;
    }
    std::filesystem::path folder = test::fresh_folder();
};

constexpr const char* sensor =
    "[top]\npositions = 1\n[side]\npositions = 1\n[accelerometer]\naxes = 1\ngravity = 0\nyaw_deg = "
    "0\nhigh_pass_hz = 0.33\nlowpass_hz = 400\n";

// The turn of the set-point's phi that a sensor nobody knows makes is 25 mrad.
TEST_F(CalibrateResponseTest, WithItTheBaseMovesAsAsked) {
    write("scene.toml", sensor);
    const Outcome fit = calibrate("--scene scene.toml -o response.toml --json");
    ASSERT_EQ(fit.status, 0) << fit.err;
    const Outcome again = calibrate("--from response -o same.toml --json");
    EXPECT_EQ(json::parse(again.out).at("high_pass"), json::parse(fit.out).at("high_pass"));
    expect_refused("--scene scene.toml -o response.toml", "exists and is not overwritten");
    expect_refused("--scene scene.toml -o response.txt", "fit its recordings");
    const json found = json::parse(fit.out), high = found.at("high_pass"), low = found.at("low_pass");
    std::printf("corner %.4f +- %.4f Hz, low-pass %.0f +- %.0f Hz\n", high.at("hz").get<double>(),
                high.at("error_hz").get<double>(), low.at("hz").get<double>(),
                low.at("error_hz").get<double>());
    EXPECT_EQ(high.at("order"), 1);
    EXPECT_NEAR(high.at("hz"), 0.33, 4 * high.at("error_hz").get<double>());
    EXPECT_LT(high.at("error_hz"), 0.01);
    EXPECT_NEAR(low.at("hz"), 400, 4 * low.at("error_hz").get<double>());
    EXPECT_LT(low.at("error_hz"), 40);

    EXPECT_EQ(
        std::system(("/usr/bin/python3 " + test::source_dir() +
                     "/calibration/accelerometer/plot_response.py " + (folder / "response.toml").string())
                        .c_str()),
        0);
    EXPECT_TRUE(std::filesystem::exists(folder / "response.png"));

    write("known.toml", std::string{sensor} + "response = \"response.toml\"\n");
    const Outcome run = test::shakerd(
        "run --scene known.toml --gamma 1g --phi 0.6rad --periods 40 -o run.nxs --json", folder);
    ASSERT_EQ(run.status, 0) << run.err;
    const json r = json::parse(run.out);
    // A drive is locked within 0.1 % of each harmonic, so phi within some 5e-4; the errors of phi, which took
    // harmonics beyond the fitted ones for noise before, had covered a part of that.
    EXPECT_NEAR(r.at("phi_rad"), 0.6, 3 * r.at("phi_se_rad").get<double>() + 5e-4);
    const Outcome truth = test::shakerd("predict --json --gamma 1g --mu 0.113 --phi 0.6rad", folder);
    EXPECT_NEAR(r.at("v_D_true_mps"), json::parse(truth.out).at("v_D_mps"), 4e-6);
    EXPECT_EQ(test::shakerd("replay run.nxs", folder).status, 0);
    EXPECT_NE(calibrate("--from run.nxs -o again.toml").out.find("of 1 run:"), std::string::npos);

    write("twice.toml", std::string{sensor} + "response = \"response.toml\"\ntold_high_pass_hz = 0.3\n");
    const Outcome twice = test::shakerd("run --scene twice.toml --gamma 1g", folder);
    EXPECT_EQ(twice.status, 2);
    EXPECT_NE(twice.err.find("leave them out"), std::string::npos) << twice.err;
}

TEST_F(CalibrateResponseTest, ACertificateIsFittedAlike) {
    std::string table = "frequency_hz,gain,gain_error,phase_deg,phase_error_deg\n";
    for (const double hz : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
        const double x = 0.5 / hz;
        table += std::to_string(hz) + "," + std::to_string(10.2 / std::hypot(1, x)) + ",0.02," +
                 std::to_string(std::atan(x) * 180 / M_PI) + ",0.1\n";
    }
    write("certificate.csv", table);
    const Outcome fit = calibrate("--from certificate.csv -o response.toml --json");
    ASSERT_EQ(fit.status, 0) << fit.err;
    const json high = json::parse(fit.out).at("high_pass");
    EXPECT_NEAR(high.at("hz"), 0.5, 3 * high.at("error_hz").get<double>());
    EXPECT_EQ(high.at("order"), 1);
    expect_refused("--from certificate.csv certificate.csv -o other.toml", "give it alone");
    write("turned.csv",
          "frequency_hz,gain,gain_error,phase_deg,phase_error_deg\n5,10,0.02,185,0.1\n10,10,0.02,175,0.1\n"
          "20,10,0.02,182,0.1\n40,10,0.02,170,0.1\n80,10,0.02,188,0.1\n");
    expect_refused("--from turned.csv -o other.toml", "no model describes the lines");
    write("certificate.csv", table + "200,-1,0.02,0,0.1\n");
    expect_refused("--from certificate.csv -o other.toml", "certificate.csv:9: gain is -1; must be above 0");
}

TEST_F(CalibrateResponseTest, AFileWithoutAnEndingHasItsDrivesBesideIt) {
    write("scene.toml", sensor);
    const Outcome fit = calibrate("--scene scene.toml -o plain");
    EXPECT_EQ(fit.status, 0) << fit.err;
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "plain"));
    EXPECT_TRUE(std::filesystem::is_directory(folder / "plain-drives"));
}

TEST_F(CalibrateResponseTest, FitsNothingWhenADriveIsMissing) {
    write("scene.toml", sensor);
    const int status = std::system(("cd " + folder.string() + " && echo stop | " + test::build_dir() +
                                    "/shakerd calibrate response --scene scene.toml -o early.toml >out 2>err")
                                       .c_str());
    EXPECT_EQ(WEXITSTATUS(status), 2);
    std::ifstream err{folder / "err"};
    const std::string said{std::istreambuf_iterator<char>{err}, {}};
    EXPECT_NE(said.find("\"shakerd campaign early --continue --scene scene.toml\" goes on"),
              std::string::npos)
        << said;
    EXPECT_FALSE(std::filesystem::exists(folder / "early.toml"));
}

TEST_F(CalibrateResponseTest, RefusesWithTheReason) {
    expect_refused("--coupled-dc -o x.toml", "name it by --from");
    expect_refused("--camera top -o x.toml", "--camera is for another device");
    expect_refused("-o other/", "has no file name");
    expect_refused("--from . --rig bench.toml -o x.toml", "--rig is for another device");
    expect_refused("--from . -o x.toml", "has no recordings");
    expect_refused("--from . --hold 3s", "--hold is for another device");
    write("sealed.toml", "date = \"2026\"\n");
    write("scene.toml", std::string{sensor} + "response = \"sealed.toml\"\n");
    const Outcome run = test::shakerd("run --scene scene.toml --gamma 1g", folder);
    EXPECT_EQ(run.status, 2);
    EXPECT_NE(run.err.find("sealed.toml: is not a calibration file"), std::string::npos) << run.err;
    write("scene.toml", std::string{sensor} + "told_high_pass_hz = 11\n");
    const Outcome told = test::shakerd("run --scene scene.toml --gamma 1g", folder);
    EXPECT_EQ(told.status, 2);
    EXPECT_NE(told.err.find("at most 10 % is allowed"), std::string::npos) << told.err;
}

}  // namespace
}  // namespace shaker::commands
