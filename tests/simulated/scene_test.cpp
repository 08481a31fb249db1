#include "drivers/simulated/scene.hpp"

#include <gtest/gtest.h>

#include "drivers/errors.hpp"

namespace shaker {
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

TEST(SceneTest, AFileChangesOnlyWhatItNames) {
    const Scene s = parse_scene("[walker]\nmu_k = 0.2\n[top]\nnoise_dn = 5\n", "x");
    EXPECT_EQ(s.walker.mu_k, 0.2);
    EXPECT_EQ(s.walker.mu_s, 0.2);  // static friction is at least the kinetic one
    EXPECT_EQ(s.cameras[0].noise_dn, 5);
    EXPECT_EQ(s.cameras[1].noise_dn, 2);
    EXPECT_EQ(s.shaker.stiffness_npm, 9932);
}

TEST(SceneTest, RegionsFollowTheWalker) {
    const Scene left = parse_scene("", "x"), right = parse_scene("[walker]\nstart_mm = 10\n", "x");
    const auto x = [](const Scene& s) { return s.cameras[0].view.targets[0].roi_px[0]; };
    EXPECT_NEAR(x(right) - x(left), 50 / (0.4 * (1 - 12.0 / 600)), 1.01);
}

TEST(SceneTest, BadInputIsRefusedByName) {
    EXPECT_NE(refusal("[walker]\nmu = 0.2\n").find("bench.toml:2: walker.mu: this key is not known"),
              std::string::npos)
        << refusal("[walker]\nmu = 0.2\n");
    EXPECT_NE(refusal("[walkr]\nmu_k = 0.2\n").find("walkr"), std::string::npos);
    for (const char* part : {"bench.toml:2", "mu_k", "-1"})
        EXPECT_NE(refusal("[walker]\nmu_k = -1\n").find(part), std::string::npos) << part;
    EXPECT_NE(refusal("[walker]\nmu_k = \"0.2\"\n").find("mu_k"), std::string::npos);
    EXPECT_NE(refusal("[walker]\nmu_k = 0.2\nmu_s = 0.1\n").find("mu_s"), std::string::npos);
    EXPECT_NE(refusal("[top]\nexposure_s = 0.002\n").find("exposure_s"), std::string::npos);
    EXPECT_NE(refusal("[dac]\nrate_khz = 48\n").find("rate_khz"), std::string::npos);
    EXPECT_NE(refusal("[walker\n").find("bench.toml"), std::string::npos);
}

}  // namespace
}  // namespace shaker
