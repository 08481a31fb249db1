#include "daemon/commands/predict.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "drivers/errors.hpp"
#include "drivers/walker/no_stick.hpp"
#include "drivers/walker/steady_state.hpp"
#include "tests/support/paths.hpp"

namespace shaker::commands {
namespace {

using Json = nlohmann::json;
const std::string golden = test::source_dir() + "/tests/golden/physics_reference.json";

/// A temporary file, removed at the end of the test.
class CasesFile {
public:
    explicit CasesFile(const std::string& text) { std::ofstream{path_} << text; }
    explicit CasesFile(const Json& content) : CasesFile{content.dump()} {}
    CasesFile(const CasesFile&) = delete;
    CasesFile& operator=(const CasesFile&) = delete;
    ~CasesFile() { std::filesystem::remove(path_); }
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

private:
    std::filesystem::path path_ =
        std::filesystem::temp_directory_path() / ("predict_test_" + std::to_string(getpid()) + ".json");
};

Json one_case(const std::function<void(Json& params)>& change = [](Json&) {}) {
    Json params = {{"f_hz", 20},
                   {"g", 9.8},
                   {"mu_k", 0.113},
                   {"mu_s", 0.113},
                   {"tilt_deg", 0},
                   {"base_accel", Json::array({{{"q", 1}, {"a", 4.9}, {"phase", 0}},
                                               {{"q", 2}, {"a", 4.9}, {"phase", 0}}})},
                   {"vertical_accel", Json::array()}};
    change(params);
    return {{"schema", "walker-reference-1"},
            {"cases", Json::array({{{"name", "odd one"}, {"params", params}}})}};
}

Json answers(const Json& content) { return Json::parse(predict_cases(CasesFile{content}.path())); }

std::string error_of(const std::string& text) {
    const CasesFile file{text};
    try {
        predict_cases(file.path());
    } catch (const InputError& error) {
        std::string message = error.what();
        EXPECT_NE(message.find(file.path().string()), std::string::npos) << message;
        return message;
    }
    return "accepted";
}

TEST(PredictCasesTest, EveryCaseAgreesWithReference) {
    const Json all = Json::parse(predict_cases(golden));
    const Json reference = Json::parse(std::ifstream{golden});
    EXPECT_EQ(all.size(), reference.at("cases").size());
    for (const Json& c : reference.at("cases")) {
        SCOPED_TRACE(c.at("name"));
        const Json& mine = all.at(c.at("name").get<std::string>());
        const Json& right = c.at("answer");
        double V = 0;
        for (const Json& term : c.at("params").at("base_accel"))
            V += term.at("a").get<double>() / (two_pi * 20);
        EXPECT_NEAR(mine.at("v_D"), right.at("v_D"), 1e-10 * V);
        EXPECT_NEAR(mine.at("eta"), right.at("eta"), 1e-10);
        EXPECT_NEAR(mine.at("v_at_t0"), right.at("v_at_t0"), 1e-10 * V);
        EXPECT_EQ(mine.at("state_at_t0"), right.at("state_at_t0"));
        EXPECT_NEAR(mine.at("stick_fraction"), right.at("stick_fraction"), 1e-9);
        for (std::size_t k = 0; k < 5; ++k) {
            EXPECT_NEAR(mine.at("startup_D")[k], right.at("startup_D")[k], 1e-10 * V / 20);
        }
        ASSERT_EQ(mine.at("events").size(), right.at("events").size());
        for (std::size_t e = 0; e < right.at("events").size(); ++e) {
            const Json &event = mine.at("events")[e], &other = right.at("events")[e];
            EXPECT_NEAR(event[0], other[0], 1e-9);
            EXPECT_EQ(event[1], other[1]);
            EXPECT_EQ(event[2], other[2]);
        }
    }
}

TEST(PredictCasesTest, NumbersCarryAllTheDigitsOfADouble) {
    const Json answer = answers(one_case()).at("odd one");
    const double v_D = answer.at("v_D"), D = answer.at("D");
    EXPECT_NEAR(v_D * 0.05 / D, 1, 4e-16);  // two roundings
}

TEST(PredictCasesTest, EachLawGivesItsCycleAndItsVelocity) {
    for (const std::string_view law : walker::friction_laws) {
        SCOPED_TRACE(law);
        const Json found = answers(one_case([&](Json& p) {
                               p["law"] = law;
                               p["mu_s"] = law == "stribeck" || law == "lugre" ? 0.13 : 0.113;
                               p["viscous"] = 2;
                               p["phases"] = 400;
                           })).at("odd one");
        walker::WalkerSetting same;
        same.frequency = 20;
        same.friction.law = static_cast<walker::FrictionLaw>(std::ranges::find(walker::friction_laws, law) -
                                                             walker::friction_laws.begin());
        same.friction.viscous = 2;
        same.friction.mu_s = law == "stribeck" || law == "lugre" ? 0.13 : 0.113;
        same.base.at(1) = same.base.at(2) = 4.9;
        const double V = 9.8 / (two_pi * 20);
        EXPECT_NEAR(found.at("v_D"), settle(same).v_D, 1e-7 * V);
        double mean = 0;
        ASSERT_EQ(found.at("v").size(), 400U);
        for (const double v : found.at("v")) mean += v / 400;
        EXPECT_NEAR(mean, found.at("v_D"), 1e-4 * V);  // of 400 phases, with kinks
        EXPECT_NEAR(found.at("v")[0], found.at("v_at_t0"), 1e-7 * V);
    }
    EXPECT_NE(error_of(one_case([](Json& p) { p["law"] = "Dhal"; }).dump())
                  .find("law is \"Dhal\"; known are coulomb, logarithmic"),
              std::string::npos);
}

TEST(PredictCasesTest, TheStartChoosesBetweenTwoCycles) {
    const auto drift_from = [](double v_start) {
        return answers(one_case([v_start](Json& p) {
                   p["mu_s"] = 0.3;
                   for (auto& term : p["base_accel"]) term["a"] = 1.6772 * 4.9;
                   p["base_accel"][1]["phase"] = 3.1302;
                   p["v_start"] = v_start;
               }))
            .at("odd one")
            .at("v_D")
            .get<double>();
    };
    std::set<int> micrometres;
    for (int i = -10; i <= 10; ++i)
        micrometres.insert(static_cast<int>(std::lround(1e6 * drift_from(0.013 * i))));
    EXPECT_EQ(micrometres, (std::set<int>{-31666, -29614}));  // -31.6656 and -29.6135 mm/s
}

TEST(PredictCasesTest, ADriveWithoutHarmonicsNeverMoves) {
    for (const bool listed : {false, true}) {
        const Json answer = answers(one_case([listed](Json& p) {
                                p["base_accel"] = Json::array();
                                if (listed) p["base_accel"].push_back({{"q", 16}, {"a", 0}, {"phase", 1}});
                            })).at("odd one");
        EXPECT_EQ(answer.at("v_D"), 0);
        EXPECT_EQ(answer.at("stick_fraction"), 1);
        EXPECT_TRUE(answer.at("events").empty());
        EXPECT_TRUE(answer.at("eta").is_null());
    }
}

TEST(PredictCasesTest, MalformedCasesAreRefusedByFileCaseAndKey) {
    const auto refused = [](const std::string& key, const std::function<void(Json&)>& change) {
        const std::string message = error_of(one_case(change).dump());
        EXPECT_NE(message.find("case 'odd one'"), std::string::npos) << message;
        EXPECT_NE(message.find(key), std::string::npos) << key << " is not named by: " << message;
    };
    for (const std::string key : {"f_hz", "g", "mu_k", "mu_s", "tilt_deg", "base_accel", "vertical_accel"}) {
        refused(key, [&](Json& p) { p.erase(key); });
        for (const Json& wrong : {Json("text"), Json(nullptr), Json(true), Json::object()}) {
            refused(key, [&](Json& p) { p[key] = wrong; });
        }
    }
    refused("f_hz", [](Json& p) { p["f_hz"] = 0; });
    refused("f_hz", [](Json& p) { p["f_hz"] = -20; });
    refused("g", [](Json& p) { p["g"] = 0; });
    refused("mu_k", [](Json& p) { p["mu_k"] = -0.1; });
    refused("mu_s", [](Json& p) { p["mu_s"] = 0.1; });
    refused("tilt_deg", [](Json& p) { p["tilt_deg"] = 90; });
    refused("tilt_deg", [](Json& p) { p["tilt_deg"] = 10; });  // slides away
    refused("v_start", [](Json& p) { p["v_start"] = "fast"; });
    refused("'mu'", [](Json& p) { p["mu"] = 0.1; });
    refused("vertical_accel", [](Json& p) { p["vertical_accel"] = {{{"q", 1}, {"a", 9.9}, {"phase", 0}}}; });
    for (const char* list : {"base_accel", "vertical_accel"}) {
        for (const Json& q : {Json(0), Json(17), Json(-1), Json(1.5), Json("1"), Json(nullptr)}) {
            refused("q is", [&](Json& p) { p[list] = {{{"q", q}, {"a", 1}, {"phase", 0}}}; });
        }
        refused("'a'", [&](Json& p) { p[list] = {{{"q", 1}, {"phase", 0}}}; });
        refused("phase", [&](Json& p) { p[list] = {{{"q", 1}, {"a", 1}, {"phase", {}}}}; });
        refused("'b'", [&](Json& p) { p[list] = {{{"q", 1}, {"a", 1}, {"phase", 0}, {"b", 0}}}; });
        refused(list, [&](Json& p) { p[list] = {1, 2}; });
    }
}

TEST(PredictCasesTest, FilesThatAreNotListsOfCasesAreRefused) {
    for (const char* text : {"", "{", "[]", "3", "null", "{}", R"({"cases": 3})", R"({"cases": [3]})",
                             R"({"cases": [{}]})", R"({"cases": [{"name": 3, "params": {}}]})",
                             R"({"cases": [{"name": "a"}]})", R"({"cases": [{"name": "a", "params": []}]})",
                             "{\"cases\": [{\"name\": \"\xff\", \"params\": {}}]}",
                             R"({"cases": [{"name": "a", "params": {"f_hz": 1e999}}]})"}) {
        EXPECT_NE(error_of(text), "accepted") << text;
    }
    Json twice = one_case();
    twice["cases"].push_back(twice["cases"][0]);
    EXPECT_NE(error_of(twice.dump()).find("twice"), std::string::npos);
    EXPECT_THROW(predict_cases("/nonexistent/cases.json"), InputError);
    EXPECT_EQ(answers({{"cases", Json::array()}}), Json::object());
}

TEST(PredictTest, JsonHasExactMotionAndClosedForm) {
    const Json j = Json::parse(predict({.drive = {.gamma = 9.8}, .json = true}));
    EXPECT_NEAR(j.at("v_D_mps"), 0.01458239344603039, 1e-14);
    EXPECT_NEAR(j.at("D_m"), 0.0007291196723015195, 1e-15);
    EXPECT_NEAR(j.at("efficiency"), 0.4730451422568342, 1e-12);
    EXPECT_EQ(j.at("frequency_hz"), 20);
    EXPECT_EQ(j.at("gamma_mps2"), 9.8);
    EXPECT_EQ(j.at("rho"), 0.5);
    EXPECT_EQ(j.at("phi_rad"), 0);
    EXPECT_TRUE(j.at("stick").empty());
    EXPECT_EQ(j.at("events").size(), 2U);
    const Json& closed = j.at("closed_form");
    EXPECT_TRUE(closed.at("valid").get<bool>());
    EXPECT_NEAR(closed.at("v_D_mps"), 0.01458239344603039, 1e-13);
    EXPECT_NEAR(closed.at("theta_rad"), 2 * std::asin(std::numbers::pi * 0.113), 1e-12);
    EXPECT_EQ(closed.at("theta_coulomb_rad"), walker::coulomb_theta(1 / 0.113));
}

TEST(PredictTest, ClosedFormIsMarkedExactOnlyWhenValid) {
    const auto valid = [](const PredictOptions& options) {
        const Json closed = Json::parse(predict(options)).at("closed_form");
        EXPECT_EQ(closed.at("valid").get<bool>(), closed.at("reason").get<std::string>().empty());
        return closed.at("valid").get<bool>();
    };
    PredictOptions good{.drive = {.gamma = 19.6}, .json = true};
    EXPECT_TRUE(valid(good));
    for (const auto& change : std::initializer_list<std::function<void(PredictOptions&)>>{
             [](PredictOptions& o) { o.drive.gamma = 4.9; }, [](PredictOptions& o) { o.drive.phi = 1.5; },
             [](PredictOptions& o) { o.tilt = 0.01; }, [](PredictOptions& o) { o.friction.viscous = 3; },
             [](PredictOptions& o) { o.friction.mu_s = 0.9; }}) {
        PredictOptions changed = good;
        change(changed);
        EXPECT_FALSE(valid(changed));
    }
}

TEST(PredictTest, TextHasEveryValue) {
    const std::string text = predict({.drive = {.gamma = 4.9}});
    for (const char* words :
         {"3.08442 mm/s", "efficiency", "V_RMS", "0.505728 to 0.707218 T", "settled after",
          "exact here      no:", "Theta", "0.140698624 T     slips backward"}) {
        EXPECT_NE(text.find(words), std::string::npos) << words << " is not in\n" << text;
    }
    EXPECT_EQ(text.back(), '\n');
}

TEST(PredictTest, ABaseAtRestHasNoEfficiency) {
    const PredictOptions still{.drive = {.gamma = 0}, .json = true};
    EXPECT_TRUE(Json::parse(predict(still)).at("efficiency").is_null());
    EXPECT_NE(predict({.drive = {.gamma = 0}}).find("at rest"), std::string::npos);
}

TEST(PredictTest, OptionsOutOfRangeAreRefused) {
    EXPECT_THROW(predict({.drive = {.rho = 1.1}}), InputError);
    EXPECT_THROW(predict({.drive = {.rho = NAN}}), InputError);
    EXPECT_THROW(predict({.drive = {.gamma = -1}}), InputError);
    EXPECT_THROW(predict({.drive = {.frequency = 0}}), InputError);
    EXPECT_THROW(predict({.friction = {0.2, 0.1, 0}}), InputError);
    EXPECT_THROW(predict({.v_start = NAN}), InputError);
}

}  // namespace
}  // namespace shaker::commands
