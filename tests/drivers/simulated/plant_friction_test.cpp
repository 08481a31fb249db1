// The laws of friction on the shaker's table.
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/errors.hpp"
#include "drivers/walker/steady_state.hpp"
#include "tests/support/control/bench_drive.hpp"

namespace shaker::simulated {
namespace {

constexpr long period = 2400;  // samples at 20 Hz

/// Mean drift (m/s) over `last` periods after `first`.
double drift(const Scene& scene, const Drive& drive, long first, long last = 1) {
    ShakerPlant plant{scene};
    const auto volts = test::samples(test::volts_for(scene, drive), drive.frequency, scene.dac_rate_hz, 0,
                                     static_cast<std::size_t>((first + last) * period));
    double from = 0;
    for (std::size_t i = 0; i < volts.size(); ++i) {
        if (i == static_cast<std::size_t>(first * period)) from = plant.state().walker_x;
        plant.step(volts[i]);
    }
    return (plant.state().walker_x - from) * 20 / static_cast<double>(last);
}

Scene scene_of(const std::string& walker) {
    Scene s = parse_scene("[walker]\n" + walker, "x");
    s.walker.mass_kg = 1e-9;
    return s;
}

TEST(PlantFrictionTest, MasslessWalkerObeysEachLaw) {
    for (const char* keys :
         {"viscous_per_s = 3.5", "backward_ratio = 0.9", "law = \"logarithmic\"\nlog_share = 0.1",
          "law = \"dahl\"\ndahl_um = 7.2\nviscous_per_s = 4.2", "ageing = 0.05",
          "law = \"stribeck\"\nmu_s = 0.13\nstribeck_mps = 0.02"})
        for (const Drive& drive_ : {Drive{.gamma = 9.8}, Drive{.gamma = 4.9, .phi = 0.4}}) {
            const Scene scene = scene_of(keys);
            walker::WalkerSetting setting;
            setting.base = harmonics(drive_);
            setting.friction = friction_of(scene);
            EXPECT_NEAR(drift(scene, drive_, 120), walker::settle(setting).v_D,
                        5e-6 * drive_.gamma / (two_pi * 20))
                << keys << ", gamma " << drive_.gamma;
        }
}

TEST(PlantFrictionTest, ErrorFallsWithSquareOfSample) {
    const Drive asked{.gamma = 9.8};
    const auto error = [&](double rate) {
        Scene s = scene_of("law = \"dahl\"");
        s.dac_rate_hz = rate;
        walker::WalkerSetting setting;
        setting.base = harmonics(asked);
        setting.friction = friction_of(s);
        ShakerPlant plant{s};
        const auto samples = std::lround(rate / 20);
        const auto volts =
            test::samples(test::volts_for(s, asked), 20, rate, 0, static_cast<std::size_t>(121 * samples));
        double from = 0;
        for (std::size_t i = 0; i < volts.size(); ++i) {
            if (i == static_cast<std::size_t>(120 * samples)) from = plant.state().walker_x;
            plant.step(volts[i]);
        }
        return std::abs((plant.state().walker_x - from) * 20 - walker::settle(setting).v_D);
    };
    EXPECT_LT(error(96000), error(24000) / 16);
}

TEST(PlantFrictionTest, DefaultKeysChangeNothing) {
    const Scene plain = parse_scene("", "x");
    const Scene keys =
        parse_scene("[walker]\nlaw = \"coulomb\"\nviscous_per_s = 0\nmu_jitter = 0\nmu_memory = 0.9", "x");
    ShakerPlant a{plain}, b{keys};
    const auto volts = test::samples(test::volts_for(plain, {}), 20, 48000, 0, 20 * period);
    for (const double v : volts) {
        a.step(v);
        b.step(v);
        ASSERT_EQ(a.state().walker_x, b.state().walker_x);
        ASSERT_EQ(a.state().x, b.state().x);
    }
}

TEST(PlantFrictionTest, ConstantLawByStepsIsExactLaw) {
    // Jitter of almost nothing: the grip is evaluated in each sample and hardly differs.
    Scene plain = parse_scene("", "x"), stepped = parse_scene("[walker]\nmu_jitter = 1e-15", "x");
    ShakerPlant a{plain}, b{stepped};
    const auto volts = test::samples(test::volts_for(plain, {}), 20, 48000, 0, 40 * period);
    for (const double v : volts) {
        a.step(v);
        b.step(v);
    }
    EXPECT_NEAR(a.state().walker_x, b.state().walker_x, 1e-13);
    EXPECT_EQ(a.events(), b.events());
}

TEST(PlantFrictionTest, JitterFollowsSceneSeed) {
    const auto walked = [](const std::string& seed) {
        Scene s = parse_scene("seed = " + seed + "\n[walker]\nmu_jitter = 0.05\nmu_memory = 0.5", "x");
        return drift(s, {}, 20, 20);
    };
    EXPECT_EQ(walked("1"), walked("1"));
    EXPECT_NE(walked("1"), walked("2"));
    const double plain = drift(paper_scene(), {}, 20, 20);
    EXPECT_NEAR(walked("1"), plain, 0.1 * plain);
}

TEST(PlantFrictionTest, RelaxationStartsHighAndDiesAway) {
    Scene s = parse_scene("[walker]\nmu_relaxation = 0.5\nrelaxation_s = 0.3", "x");
    const double plain = drift(paper_scene(), {}, 80, 20);
    EXPECT_NEAR(drift(s, {}, 80, 20), plain, 1e-4 * plain);
    EXPECT_GT(std::abs(drift(s, {}, 10, 2) - drift(paper_scene(), {}, 10, 2)), 1e-3 * plain);
}

TEST(PlantFrictionTest, RoughSurfaceChangesPeriods) {
    const Scene s = parse_scene("[walker]\nroughness = 0.1\nroughness_mm = 3", "x");
    const double plain = drift(paper_scene(), {}, 40, 20);
    EXPECT_NEAR(drift(s, {}, 40, 20), plain, 0.1 * plain);
    EXPECT_NE(drift(s, {}, 40, 1), drift(s, {}, 41, 1));
}

// No spring, no damper, no drive: the sum of momenta is that of the weight.
TEST(PlantFrictionTest, MomentumIsKeptUnderEachLaw) {
    for (const char* keys :
         {"", "law = \"dahl\"", "viscous_per_s = 20", "law = \"logarithmic\"", "roughness = 0.1"}) {
        Scene s = parse_scene(std::string{"[walker]\n"} + keys, "x");
        s.shaker.stiffness_npm = 0;
        s.shaker.damping_nspm = 0;
        s.shaker.force_factor_npa = 1e-6;
        s.tilt_deg = 10;  // slides: tan 10 deg > mu
        ShakerPlant plant{s};
        for (int i = 0; i < 4800; ++i) plant.step(0);
        const double weight = s.walker.mass_kg * s.gravity * std::sin(10 * std::numbers::pi / 180) * 0.1;
        const double base = (s.shaker.moving_mass_kg + s.shaker.base_mass_kg) * plant.state().v;
        EXPECT_EQ(plant.state().slip, 1) << keys;
        EXPECT_NEAR(base + s.walker.mass_kg * plant.state().walker_v, weight, 1e-9 * weight) << keys;
    }
}

TEST(PlantFrictionTest, KeysOutOfRangeAreRefusedByName) {
    const auto refusal = [](const std::string& key) -> std::string {
        try {
            parse_scene("[walker]\n" + key, "bench.toml");
        } catch (const InputError& e) {
            return e.what();
        }
        return "accepted";
    };
    for (const char* key :
         {"viscous_per_s = -1", "backward_ratio = 0", "mu_jitter = 0.5", "mu_memory = 1.0",
          "mu_relaxation = -1", "relaxation_s = 0", "ageing = 2", "roughness = 0.3", "roughness_mm = 0",
          "dahl_um = 0", "stribeck_mps = 0", "law = \"stribeck\"\nmu_k = 0", "log_share = -0.1",
          "mu_step_s = 0", "law = \"dahl\"\nageing = 0.1"}) {
        const std::string why = refusal(key);
        EXPECT_NE(why.find("bench.toml"), std::string::npos) << key << ": " << why;
    }
    const std::string unknown = refusal("law = \"lugre\"");
    EXPECT_NE(unknown.find("lugre"), std::string::npos) << unknown;
    for (const char* law : {"coulomb", "logarithmic", "dahl", "stribeck"})
        EXPECT_NE(unknown.find(law), std::string::npos) << unknown;
}

TEST(PlantFrictionTest, TextOfSceneKeepsItsFriction) {
    const Scene s =
        parse_scene("[walker]\nlaw = \"dahl\"\ndahl_um = 3.3\nmu_jitter = 0.02\nmu_memory = 0.9", "x");
    const std::string text = scene_text(s);
    const Scene back = parse_scene(text, "y");
    EXPECT_EQ(scene_text(back), text);
    EXPECT_EQ(back.walker.law, walker::FrictionLaw::dahl);
    EXPECT_EQ(back.walker.dahl_um, 3.3);
    EXPECT_EQ(back.walker.mu_memory, 0.9);
    EXPECT_EQ(scene_text(paper_scene()).find("law ="), std::string::npos);
}

}  // namespace
}  // namespace shaker::simulated
