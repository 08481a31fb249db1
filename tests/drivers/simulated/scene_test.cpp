#include "drivers/simulated/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker::simulated {
namespace {

std::string refusal(const std::string& toml) {
    try {
        parse_scene(toml, "bench.toml");
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

TEST(SceneTest, ItsTextReadsBackAsTheSameScene) {
    Scene s = paper_scene();
    s.seed = 77;
    s.walker.mu_k = 0.1 + 1e-17;
    s.shaker.high_pass_hz[1] = 1.0 / 3;
    s.accelerometer.yaw_deg = -1e-9;
    const std::string text = scene_text(s);
    const Scene back = parse_scene(text, "x");
    EXPECT_EQ(scene_text(back), text);
    EXPECT_EQ(back.seed, 77U);
    EXPECT_EQ(back.shaker.high_pass_hz[1], 1.0 / 3);
}

TEST(SceneTest, StoresErrorsOfTheSensorOnlyWhereThereAreAny) {
    EXPECT_EQ(scene_text(paper_scene()).find("gain_x"), std::string::npos);
    const Scene s = parse_scene(
        "[accelerometer]\ngain_y = -1.02\ncross_xz = 0.01\noffset_z_mps2 = 0.3\ncalibration = 'cal.toml'\n"
        "attitudes = '+x -x+y'\nhold_s = 4\n",
        "x");
    EXPECT_EQ(s.accelerometer.gain,
              (std::array<std::array<double, 3>, 3>{{{1, 0, 0.01}, {0, -1.02, 0}, {0, 0, 1}}}));
    EXPECT_EQ(s.accelerometer.offset_mps2[2], 0.3);
    const Scene back = parse_scene(scene_text(s), "x");
    EXPECT_EQ(scene_text(back), scene_text(s));
    EXPECT_EQ(back.accelerometer.attitudes, "+x -x+y");
    EXPECT_EQ(back.accelerometer.calibration, "cal.toml");
}

TEST(SceneTest, NamesAWrongAttitude) {
    EXPECT_EQ(
        refusal("[accelerometer]\nattitudes = '+x up'\n"),
        "bench.toml:2: accelerometer.attitudes: \"up\" is not an attitude: expected the axes that point up, "
        "for example \"+x -x +y +x-z\"");
}

TEST(SceneTest, FileChangesOnlyItsKeys) {
    const Scene s = parse_scene("[walker]\nmu_k = 0.2\n[top]\nnoise_dn = 5\n", "x");
    EXPECT_EQ(s.walker.mu_k, 0.2);
    EXPECT_EQ(s.walker.mu_s, 0.2);  // static friction is at least the kinetic one
    EXPECT_EQ(s.cameras[0].noise_dn, 5);
    EXPECT_EQ(s.cameras[1].noise_dn, 2);
    EXPECT_EQ(s.shaker.stiffness_npm, 9932);
}

TEST(SceneTest, KeysOverrideTheModelsDataSheet) {
    const ShakerTruth lds = parse_scene("[shaker]\nmodel = \"LDS V203\"\nstiffness_npm = 3000\n", "x").shaker;
    EXPECT_EQ(lds.moving_mass_kg, 0.0312);
    EXPECT_EQ(lds.stiffness_npm, 3000);
    EXPECT_EQ(lds.sheet.max_force_n, 19.6);
    EXPECT_EQ(lds.base_mass_kg, paper_scene().shaker.base_mass_kg);
    EXPECT_EQ(shaker_text(parse_scene("[shaker]\nmodel = \"B&K 4809\"\n", "x").shaker),
              shaker_text(paper_scene().shaker));
    // The suspension's resonance with a load, as published: 79.6 Hz bare, 26.5 Hz with 0.3 kg.
    const auto f0 = [](const char* model, double load) {
        const ShakerTruth s = parse_scene(std::string{"[shaker]\nmodel = \""} + model + "\"\n", "x").shaker;
        return std::sqrt(s.stiffness_npm / (s.moving_mass_kg + load)) / two_pi;
    };
    EXPECT_NEAR(f0("Modal Shop 2100E11", 0), 79.6, 0.05);
    EXPECT_NEAR(f0("B&K 4809", 0.3), 26.5, 0.05);
    EXPECT_NEAR(f0("LDS V203", 0.3), 14.9, 0.05);
    EXPECT_NE(refusal("[shaker]\nmodel = \"B&K 4810\"\n").find("B&K 4809"), std::string::npos);
}

TEST(SceneTest, EveryKeyOfTheShakerReadsBack) {
    Scene s = paper_scene();
    ShakerTruth& p = s.shaker;
    p.drive = DriveKind::current;
    p.cubic_stiffness_npm3 = 1.0 / 3e-10;
    p.force_factor_falloff_pm2 = 1.0 / 3e-5;
    p.static_friction_n = 0.7;
    p.kinetic_friction_n = 0.6;
    p.stop_travel_mm = 3.5;
    p.gain_drift_per_min = -0.1;
    p.sheet.stroke_mm = 5;
    const Scene back = parse_scene(scene_text(s), "x");
    EXPECT_EQ(scene_text(back), scene_text(s));
    EXPECT_EQ(back.shaker.drive, DriveKind::current);
    EXPECT_EQ(back.shaker.cubic_stiffness_npm3, p.cubic_stiffness_npm3);
    EXPECT_EQ(back.shaker.kinetic_friction_n, 0.6);
    EXPECT_EQ(back.shaker.sheet.stroke_mm, 5);
}

TEST(SceneTest, RegionsFollowTheWalker) {
    const Scene left = parse_scene("", "x"), right = parse_scene("[walker]\nstart_mm = 10\n", "x");
    const auto x = [](const Scene& s) { return s.cameras[0].view.targets[0].roi_px[0]; };
    EXPECT_NEAR(x(right) - x(left), 50 / (0.4 * (1 - 12.0 / 600)), 1.01);
}

TEST(SceneTest, BadInputIsRefusedByName) {
    EXPECT_NE(refusal("[walker]\nmu = 0.2\n").find("bench.toml:2: walker.mu: unknown key"), std::string::npos)
        << refusal("[walker]\nmu = 0.2\n");
    EXPECT_NE(refusal("[walkr]\nmu_k = 0.2\n").find("walkr"), std::string::npos);
    for (const char* part : {"bench.toml:2", "mu_k", "-1"})
        EXPECT_NE(refusal("[walker]\nmu_k = -1\n").find(part), std::string::npos) << part;
    EXPECT_NE(refusal("[walker]\nmu_k = \"0.2\"\n").find("mu_k"), std::string::npos);
    EXPECT_NE(refusal("[walker]\nmu_k = 0.2\nmu_s = 0.1\n").find("mu_s"), std::string::npos);
    const char* slide = "[shaker]\nkinetic_friction_n = 2\nstatic_friction_n = 1\n";
    EXPECT_NE(refusal(slide).find("static_friction_n"), std::string::npos);
    EXPECT_NE(refusal("[shaker]\ndrive = \"charge\"\n").find("current"), std::string::npos);
    EXPECT_NE(refusal("[top]\nexposure_s = 0.002\n").find("exposure_s"), std::string::npos);
    EXPECT_NE(refusal("[dac]\nrate_khz = 48\n").find("rate_khz"), std::string::npos);
    EXPECT_NE(refusal("[walker\n").find("bench.toml"), std::string::npos);
}

}  // namespace
}  // namespace shaker::simulated
