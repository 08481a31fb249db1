// shakerd predict with any law of friction and any harmonics, by functions and by the command line's options.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "daemon/commands/predict.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/parser.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/no_stick.hpp"

namespace shaker::commands {
namespace {

using Json = nlohmann::json;
using commands::parse_harmonics;

/// Standard output of "shakerd predict" with these options.
std::string printed(std::vector<const char*> words) {
    words.insert(words.begin(), {"shakerd", "predict"});
    const manual::ParsedLine line =
        manual::parse(commands::program(), static_cast<int>(words.size()), words.data());
    testing::internal::CaptureStdout();
    try {
        manual::find(commands::program(), "predict")->act(line.values);
    } catch (...) {
        testing::internal::GetCapturedStdout();
        throw;
    }
    return testing::internal::GetCapturedStdout();
}

TEST(PredictLawsTest, ListOfHarmonicsIsRead) {
    const Harmonics<Acceleration> h = parse_harmonics("--harmonics", "1:4.9@0,2:0.5g@35deg,16:100mm/s^2");
    EXPECT_EQ(h.at(1), 4.9);
    EXPECT_NEAR(std::abs(h.at(2)), 4.9, 1e-15);
    EXPECT_NEAR(std::arg(h.at(2)), 35 * std::numbers::pi / 180, 1e-15);
    EXPECT_EQ(h.at(16), 0.1);
    EXPECT_EQ(parse_harmonics("--vertical", "").order(), 0);
    for (const char* wrong :
         {"0:1", "17:1", "x:1", "1", "1:", "1:-2", "1:2@", "1:2@3m", "1:1,1:2", "1:1,,2:1"}) {
        try {
            parse_harmonics("--harmonics", wrong);
            ADD_FAILURE() << wrong << " was accepted";
        } catch (const InputError& e) {
            EXPECT_NE(std::string{e.what()}.find("--harmonics"), std::string::npos) << e.what();
        }
    }
}

TEST(PredictLawsTest, HarmonicsGiveMotionOfDrive) {
    const Json drive = Json::parse(printed({"--gamma", "9.8", "--phi", "0.3", "--json"}));
    const Json list = Json::parse(printed({"--harmonics", "1:4.9@0,2:4.9@0.3", "--json"}));
    EXPECT_EQ(list.at("v_D_mps"), drive.at("v_D_mps"));
    EXPECT_EQ(list.at("closed_form"), drive.at("closed_form"));
    EXPECT_EQ(list.at("v_rms_mps"), drive.at("v_rms_mps"));
    EXPECT_NEAR(list.at("gamma_mps2"), 9.8, 1e-14);
    EXPECT_NEAR(list.at("phi_rad"), 0.3, 1e-14);
    EXPECT_EQ(list.at("harmonics").size(), 2U);
    EXPECT_THROW(printed({"--harmonics", "1:4.9", "--gamma", "1g"}), InputError);
}

TEST(PredictLawsTest, ClosedFormOfManyHarmonicsIsExact) {
    // Eq. (9): the odd harmonics fix t0, the even ones give v_D.
    const Json j = Json::parse(printed({"--harmonics", "1:20@0,2:9@0.1,3:2@0.2,4:2@0.1", "--json"}));
    EXPECT_TRUE(j.at("closed_form").at("valid").get<bool>()) << j.at("closed_form").at("reason");
    EXPECT_NEAR(j.at("closed_form").at("v_D_mps"), j.at("v_D_mps"), 1e-12);
    EXPECT_TRUE(j.at("closed_form").at("theta_rad").is_null());
}

TEST(PredictLawsTest, VerticalMotionAndTiltAreTaken) {
    // The reference case vert0.3g_1w_quad.
    const Json j =
        Json::parse(printed({"--harmonics", "1:4.9,2:4.9", "--vertical", "1:2.94@90deg", "--json"}));
    EXPECT_NEAR(j.at("v_D_mps"), 0.004576171962338702, 1e-14);
    EXPECT_FALSE(j.at("closed_form").at("valid").get<bool>());
    const Json tilted =
        Json::parse(printed({"--gamma", "0.68g", "--phi", "1.2", "--tilt", "-2deg", "--json"}));
    EXPECT_NEAR(tilted.at("v_D_mps"), -0.002851861892833527, 1e-14);
    EXPECT_NE(printed({"--vertical", "1:2.94@90deg"}).find("vertical motion"), std::string::npos);
    EXPECT_THROW(printed({"--vertical", "1:10"}), InputError);
}

TEST(PredictLawsTest, EveryLawGivesDrift) {
    const double coulomb = Json::parse(printed({"--json"})).at("v_D_mps");
    for (const char* law : {"coulomb", "logarithmic", "dahl", "lugre"}) {
        const Json j = Json::parse(printed({"--law", law, "--json"}));
        EXPECT_EQ(j.at("law"), law);
        EXPECT_NEAR(j.at("v_D_mps"), coulomb, 0.3 * coulomb) << law;
        EXPECT_TRUE(j.at("v_D_se_mps").is_null());
        EXPECT_EQ(j.at("closed_form").at("valid").get<bool>(), law == std::string{"coulomb"});
    }
    EXPECT_THROW(printed({"--law", "tanh"}), InputError);
    const Json viscous = Json::parse(printed({"--gamma", "3g", "--viscous", "3.5", "--json"}));
    EXPECT_LT(viscous.at("v_D_mps").get<double>(), 0.039);
    const Json backward = Json::parse(printed({"--mu-backward", "0.08", "--json"}));
    EXPECT_LT(backward.at("v_D_mps").get<double>(), coulomb);
}

TEST(PredictLawsTest, ItPrintsWhatItCannotCompute) {
    const std::string dahl = printed({"--law", "dahl"});
    EXPECT_NE(dahl.find("not computed      stick: law dahl has no exact stick"), std::string::npos) << dahl;
    EXPECT_NE(dahl.find("exact here      no: only for dry friction"), std::string::npos) << dahl;
    const std::string jitter = printed({"--jitter", "2%", "--memory", "0.9", "--periods", "160"});
    EXPECT_NE(jitter.find("not computed      cycle, stick and events"), std::string::npos) << jitter;
    EXPECT_NE(jitter.find("+-"), std::string::npos) << jitter;
    const Json j = Json::parse(printed({"--jitter", "2%", "--periods", "160", "--json"}));
    EXPECT_TRUE(j.at("events").is_null());
    EXPECT_GT(j.at("v_D_se_mps").get<double>(), 0);
    EXPECT_EQ(j.at("not_computed").size(), 1U);
    EXPECT_TRUE(Json::parse(printed({"--json"})).at("not_computed").empty());
    EXPECT_THROW(predict({.periods = 3}), InputError);
}

TEST(PredictLawsTest, DefaultsOfOptionsAreThoseOfFriction) {
    EXPECT_EQ(printed({"--law", "dahl"}), predict({.friction = {.law = walker::FrictionLaw::dahl}}));
    EXPECT_EQ(printed({"--law", "lugre"}), predict({.friction = {.law = walker::FrictionLaw::lugre}}));
    EXPECT_EQ(printed({"--law", "logarithmic"}),
              predict({.friction = {.law = walker::FrictionLaw::logarithmic}}));
    EXPECT_EQ(printed({}), predict({}));
}

}  // namespace
}  // namespace shaker::commands
