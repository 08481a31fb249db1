// Hum of the mains in the sensor that is not in the settings: the program finds and names it, and the loop
// does not drive against it. A walker that jitters settles.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/nightly.hpp"
#include "tests/support/program.hpp"

namespace shaker::run {
namespace {

using test::fresh_folder;
using test::Outcome;
using test::shakerd;

constexpr const char* positions = "[top]\npositions = 1\n[side]\npositions = 1\n";

Outcome run_in(const std::string& scene, const std::string& arguments) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "scene.toml"} << scene << positions;
    return shakerd("run --scene scene.toml --frames off --json " + arguments, folder);
}

std::string hum(double mps2, double hz) {
    return "[accelerometer]\nmains_mps2 = " + std::to_string(mps2) + "\nmains_hz = " + std::to_string(hz) +
           "\n";
}

TEST(MainsRunTest, HumBetweenHarmonicsIsFittedAndNamed) {
    for (const double hz : {50.03, 59.96, 100.06}) {  // the last: of a rectifier
        const Outcome o = run_in(hum(0.1, hz), hz > 90   ? "--frequency 22Hz"
                                               : hz > 55 ? "--frequency 24Hz"
                                                         : "");
        ASSERT_EQ(o.status, 0) << o.err;
        const auto r = nlohmann::json::parse(o.out);
        EXPECT_NEAR(r["gamma_mps2"].get<double>(), 9.8, 3e-3 * 9.8);
        EXPECT_NE(r["notes"].dump().find("mains: the accelerometer shows 0.17"), std::string::npos)
            << r["notes"];
        EXPECT_EQ(r["notes"].dump().find("degraded"), std::string::npos) << r["notes"];
    }
}

TEST(MainsRunTest, HumOnADrivenHarmonicDegradesTheResult) {
    const Outcome o = run_in(hum(0.02, 50.03), "--frequency 25Hz");
    ASSERT_EQ(o.status, 0) << o.err;
    const auto r = nlohmann::json::parse(o.out);
    EXPECT_NE(r["notes"].dump().find("harmonic 2 of 25 Hz lies on a line of the mains"), std::string::npos)
        << r["notes"];
    EXPECT_TRUE(r["degraded"].get<bool>());
}

TEST(MainsRunTest, ABenchWithoutHumSaysNothing) {
    const Outcome o = run_in("", "--periods 10");
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_EQ(o.out.find("mains"), std::string::npos);
}

// The walker's own jitter keeps the settling of the drive open no longer than the drive needs.
TEST(SettlingTest, AWalkerThatJittersIsMeasuredSoon) {
    const int seeds = test::plays(6, 100);
    double longest = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
        const Outcome o =
            run_in("seed = " + std::to_string(seed) + "\n[walker]\nmu_jitter = 0.02\nmu_memory = 0.5\n",
                   "--phi 35deg --gamma 0.7g");
        ASSERT_EQ(o.status, 0) << o.err;
        const auto r = nlohmann::json::parse(o.out);
        longest = std::max(longest, r["from_s"].get<double>());
        EXPECT_EQ(r["notes"].dump().find("not settled"), std::string::npos) << r["notes"];
    }
    EXPECT_LT(longest, 10.2) << "before its scatter counted, one of six walked to the edge instead";
}

}  // namespace
}  // namespace shaker::run
