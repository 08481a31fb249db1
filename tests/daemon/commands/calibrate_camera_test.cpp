#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "calibration/camera/camera_file.hpp"
#include "calibration/camera/plane_fit.hpp"
#include "drivers/optics/bar_code.hpp"
#include "drivers/simulated/true_view.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

using nlohmann::json;
using test::Outcome;

struct CalibrateCameraTest : testing::Test {
    ~CalibrateCameraTest() override { std::filesystem::remove_all(folder); }
    void write(const std::string& name, const std::string& text) const {
        std::ofstream{folder / name} << text;
    }
    [[nodiscard]] std::string read(const std::string& name) const {
        std::ifstream in{folder / name, std::ios::binary};
        return {std::istreambuf_iterator<char>{in}, {}};
    }
    [[nodiscard]] Outcome calibrate(const std::string& arguments) const {
        return test::shakerd("calibrate camera " + arguments, folder);
    }
    // A picture of a board in a plane, as a PGM file.
    void picture(const std::string& name, const View& truth, double turn_rad, double offset_mm) const {
        constexpr int width = 360, height = 240;
        optics::BoardPose pose{.turn_rad = turn_rad, .offset_mm = offset_mm};
        pose.origin_mm = optics::place_at(truth, offset_mm, {0.5 * width, 0.5 * height});
        pose.origin_mm = pose.place_of({-85, -55});
        const auto pixels = optics::board_picture({}, truth, pose, width, height, {}, 1);
        std::ofstream{folder / name, std::ios::binary} << "P5 360 240 255\n"
                                                       << std::string{pixels.begin(), pixels.end()};
    }
    void expect_refused(const std::string& arguments, const std::string& words) const {
        const Outcome o = calibrate(arguments);
        EXPECT_EQ(o.status, 2) << arguments;
        EXPECT_NE(o.err.find(words), std::string::npos) << o.err;
    }
    std::filesystem::path folder = test::fresh_folder();
};

TEST_F(CalibrateCameraTest, FitsPicturesFromFiles) {
    View truth;
    truth.mm_per_px = 0.31;
    truth.distance_mm = 620;
    truth.tilt_deg = {2, -1};
    truth.lens = {.centre_px = {181, 118}, .focal_px = 2000, .k1 = -0.3};
    picture("a.pgm", truth, 0.1, 0);
    picture("b.pgm", truth, -0.2, 0);
    picture("up.pgm", truth, 0.05, 12);
    const Outcome o = calibrate(
        "--from ./a.pgm ./b.pgm --raised ./up.pgm --raised-by 12mm --distance 600mm --camera side -o "
        "cal.toml "
        "--corners corners.csv --json");
    ASSERT_EQ(o.status, 0) << o.err;
    const auto c = calibration::parse_camera_calibration(read("cal.toml"), "cal.toml");
    EXPECT_EQ(c.camera, "side");
    EXPECT_EQ(c.pictures, 3);
    EXPECT_EQ(json::parse(o.out).at("mm_per_px").get<double>(), c.mm_per_px);
    View fit;
    fit.mm_per_px = c.mm_per_px;
    fit.distance_mm = c.distance_mm;
    fit.tilt_deg = c.tilt_deg;
    fit.lens = c.lens;
    EXPECT_GT(c.scale_error, 2e-4);  // that of the board
    for (const double offset : {0.0, 12.0})
        EXPECT_NEAR(
            calibration::mean_scale(fit, offset, 360, 240) / calibration::mean_scale(truth, offset, 360, 240),
            1, c.scale_error);
    const std::string table = read("corners.csv");
    EXPECT_TRUE(table.starts_with(
        "# width_px = 360, height_px = 240\npicture,name,x_px,y_px,off_x_px,off_y_px,used\n"))
        << table.substr(0, 100);
    EXPECT_EQ(std::ranges::count(table, '\n'), 2 + c.corners);
}

TEST_F(CalibrateCameraTest, PrintsTheBoardAtItsExactSize) {
    const Outcome o = calibrate("--print board.pdf --square 12mm --marker 9mm --columns 9 --rows 7");
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.out.find("measure 108 mm over 9 squares"), std::string::npos) << o.out;
    const std::string pdf = read("board.pdf");
    EXPECT_TRUE(pdf.starts_with("%PDF-1.4\n"));
    EXPECT_NE(pdf.find("/MediaBox [0 0 442.2047 374.1732]"), std::string::npos);  // 156 x 132 mm
    EXPECT_NE(pdf.find("\n24.00000 96.00000 12.00000 1.50000 re\n"), std::string::npos) << pdf.substr(0, 900);
}

// Ghostscript draws the page with 100 pixels a mm.
TEST_F(CalibrateCameraTest, PrintsAStripWithItsBarsInPlace) {
    const auto strip = [&](const std::string& more) {
        return test::shakerd("calibrate strip -o strip.pdf " + more, folder);
    };
    const Outcome o = strip("--strip-length 60mm --strip-height 5mm --seed 7");
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_NE(strip("").err.find("exists and is not overwritten"), std::string::npos);
    EXPECT_NE(strip("--bar-least 9mm").err.find("must be at most --bar-most"), std::string::npos);
    EXPECT_NE(strip("--strip-length 30mm").err.find("tracking needs 8"), std::string::npos);
    EXPECT_NE(strip("--hold 3s").err.find("--hold is for another device"), std::string::npos);
    const std::string draw = "cd '" + folder.string() +
                             "' && gs -q -dNOPAUSE -dBATCH -sDEVICE=pgmraw -r2540 -sOutputFile=strip.pgm "
                             "strip.pdf";
    ASSERT_EQ(std::system(draw.c_str()), 0);
    std::ifstream in{folder / "strip.pgm", std::ios::binary};
    std::string type, comment;
    std::size_t width = 0, height = 0, most = 0;
    in >> type;
    for (std::getline(in, comment); in.peek() == '#';) std::getline(in, comment);
    in >> width >> height >> most;
    in.get();
    EXPECT_NEAR(static_cast<double>(width), 8000, 1);
    EXPECT_NEAR(static_cast<double>(height), 4000, 1);
    std::string row(width, ' ');
    const auto changes_in = [&](std::size_t y) {
        in.seekg(-static_cast<std::streamoff>((height - y) * width), std::ios::end);
        in.read(row.data(), static_cast<std::streamsize>(width));
        std::vector<double> changes;
        for (std::size_t x = 1; x < width; ++x)
            if ((row[x] == 0) != (row[x - 1] == 0)) changes.push_back(0.01 * static_cast<double>(x));
        return changes;
    };
    const std::vector<double> seen = changes_in(1250), edges = optics::edges_of({.seed = 7, .length_mm = 60});
    ASSERT_EQ(seen.size(), edges.size());
    for (std::size_t k = 0; k < edges.size(); ++k) EXPECT_NEAR(seen[k], 10 + edges[k], 0.011);
    const std::vector<double> ruler = changes_in(height - 1815);
    ASSERT_EQ(ruler.size(), 2U);
    EXPECT_NEAR(ruler[0], 10, 0.011);
    EXPECT_NEAR(ruler[1], 70, 0.011);
}

TEST_F(CalibrateCameraTest, TakesAKnownLength) {
    const Outcome o = calibrate("--length 100mm --ends 10,20,310,20 --size 320,96 -o cal.toml");
    ASSERT_EQ(o.status, 0) << o.err;
    const auto c = calibration::parse_camera_calibration(read("cal.toml"), "cal.toml");
    EXPECT_DOUBLE_EQ(c.mm_per_px, 1.0 / 3);
    EXPECT_NEAR(c.scale_error, std::hypot(0.001, std::sqrt(2.0) * 0.5 / 300), 1e-12);
    EXPECT_EQ(c.lens.focal_px, 0);
    expect_refused("--length 100mm -o b.toml", "needs --ends");
    expect_refused("--length 100mm --ends 1,2,3 --size 320,96 -o b.toml",
                   "--ends \"1,2,3\": expected 4 numbers");
}

TEST_F(CalibrateCameraTest, RefusesOptionsThatDoNotFit) {
    expect_refused("--from a.png -o cal.toml", "expected --distance");
    expect_refused("--from a.png --distance 600mm -o cal.toml", "a.png: is not an image that can be read");
    expect_refused("--g 9.8m/s^2", "--g is for the accelerometer");
    expect_refused("--columns 100 --rows 100 --print b.pdf", "need 5000 markers; 250 are known");
    expect_refused("--square 5mm --print b.pdf", "--marker 7 mm: must be less than --square, 5 mm");
    expect_refused("--camera front", "--camera front: no such camera; the rig has top, side");
    const Outcome o = test::shakerd("calibrate accelerometer --g 9.8m/s^2 --square 5mm", folder);
    EXPECT_NE(o.err.find("--square is for another device"), std::string::npos) << o.err;
}

// A bench whose scale, lens and tilt differ from its settings is calibrated with a board, and then finds the
// drift that it really has.
TEST_F(CalibrateCameraTest, CalibratesTheSimulatedBenchLive) {
    const std::string camera =
        "width_px = 480\nheight_px = 200\nmm_per_px = 0.4\ntrue_mm_per_px = 0.412\ntrue_distance_mm = 615\n"
        "true_k1 = -0.3\ntrue_tilt_x_deg = 2\nframe_rate_hz = 100\n";
    write("boards.toml",
          "[top]\n" + camera + "boards = '-35 0 2 0  0 5 -10 0  35 -5 8 0  -20 3 4 12'\nboard_s = 4\n");
    const Outcome live = calibrate(
        "--scene boards.toml --pictures 3 --raised-by 12mm --hold 1s --square 10mm --board-error 1e-5 "
        "--height-error 0.001mm -o cal.toml");
    ASSERT_EQ(live.status, 0) << live.err << live.out;
    EXPECT_NE(live.out.find("picture 4 (raised): "), std::string::npos) << live.out;
    EXPECT_NE(live.out.find("in the table [[camera]] of \"top\": calibration = \"cal.toml\""),
              std::string::npos);
    const auto c = calibration::parse_camera_calibration(read("cal.toml"), "cal.toml");
    EXPECT_NEAR(c.mm_per_px / 0.412, 1, 2e-3);
    EXPECT_LT(c.scale_error, 5e-4);
    const auto drift = [&](const std::string& top) {
        write("bench.toml", "[top]\npositions = 1\n" + top + "[side]\npositions = 1\nframe_rate_hz = 100\n");
        const Outcome o = test::shakerd(
            "run --scene bench.toml --gamma 0.5g --periods 40 --no-identify --open-loop --json", folder);
        EXPECT_EQ(o.status, 0) << o.err;
        return json::parse(o.out).at("v_D_mps").get<double>();
    };
    const double truth = drift("width_px = 480\nheight_px = 200\nframe_rate_hz = 100\n");
    EXPECT_GT(std::abs(drift(camera) / truth - 1), 0.01);
    EXPECT_NEAR(drift(camera + "calibration = 'cal.toml'\n") / truth, 1, 1e-3);
}

}  // namespace
}  // namespace shaker::commands
