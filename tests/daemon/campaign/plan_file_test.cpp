#include <gtest/gtest.h>

#include <numbers>

#include "daemon/campaign/plan.hpp"
#include "drivers/errors.hpp"

namespace shaker::campaign {
namespace {

Plan parsed(const std::string& text) { return parse_plan(text, "p.toml"); }

std::string refusal(const std::string& text) {
    try {
        parsed(text);
        return "accepted";
    } catch (const InputError& error) {
        return error.what();
    }
}

TEST(PlanFileTest, ReadsListsRangesAndUnits) {
    const Plan plan = parsed(R"(title = "Both"
mu = 0.12
[point]
frequency = "25Hz"
gamma = "2g"
periods = 60
[[series]]
phi = ["0deg", 0.5, "90deg"]
gamma = {from = "1g", to = "3g", steps = 2}
[[series]]
name = "second"
rho = "40%"
precision = "0.05mm/s"
most_periods = 100
settle = 12
repeats = 3
order = "random"
seed = 7
)");
    EXPECT_EQ(plan.title, "Both");
    EXPECT_EQ(plan.mu, 0.12);
    ASSERT_EQ(plan.series.size(), 2U);
    const Series &first = plan.series[0], &second = plan.series[1];
    EXPECT_EQ(first.name, "1");
    EXPECT_EQ(first.phi, (std::vector<double>{0, 0.5, std::numbers::pi / 2}));
    EXPECT_EQ(first.gamma, (std::vector<double>{paper_g, 2 * paper_g, 3 * paper_g}));
    EXPECT_EQ(first.frequency, std::vector<double>{25});
    EXPECT_EQ(first.rho, std::vector<double>{0.5});
    EXPECT_EQ(first.settings.plan.periods, 60);
    EXPECT_EQ(first.order, Order::listed);
    EXPECT_EQ(first.gamma_line, 9U);
    EXPECT_EQ(second.gamma, std::vector<double>{2 * paper_g});
    EXPECT_EQ(second.gamma_line, 5U);
    EXPECT_EQ(second.rho, std::vector<double>{0.4});
    EXPECT_EQ(second.settings.precision, 5e-5);
    EXPECT_EQ(second.settings.least_periods, 20);
    EXPECT_EQ(second.settings.most_periods, 100);
    EXPECT_EQ(second.settings.plan.settle, 12);
    EXPECT_EQ(second.order, Order::random);
    EXPECT_EQ(second.seed, 7U);
    EXPECT_EQ(second.repeats, 3);
    EXPECT_EQ(second.line, 10U);
}

TEST(PlanFileTest, ReadsSetsOfHarmonics) {
    const Plan plan = parsed(R"([[series]]
harmonics = [
  [],
  [{n = 3, share = "10%", phase = "90deg"}, {n = 8, share = 0.2}],
]
)");
    ASSERT_EQ(plan.series.at(0).overtones.size(), 2U);
    EXPECT_EQ(plan.series[0].overtones[0], Overtones{});
    EXPECT_NEAR(std::abs(plan.series[0].overtones[1][0] - std::complex<double>(0, 0.1)), 0, 1e-15);
    EXPECT_EQ(plan.series[0].overtones[1][5], 0.2);
}

TEST(PlanFileTest, PeriodsOfASeriesReplaceAPrecision) {
    const Plan plan = parsed("[point]\nprecision = \"1mm/s\"\n[[series]]\nperiods = 30\n[[series]]\n");
    EXPECT_EQ(plan.series[0].settings.precision, 0);
    EXPECT_EQ(plan.series[0].settings.plan.periods, 30);
    EXPECT_EQ(plan.series[1].settings.precision, 1e-3);
}

TEST(PlanFileTest, RefusalsNameLineKeyAndRange) {
    struct Case {
        std::string text, message;
    };
    const std::string series = "[[series]]\n";
    for (const Case& c : {
             Case{"title = 3\n", "p.toml:1: title: expected a string"},
             Case{"[point]\n", "p.toml:1: series: missing; expected at least one table [[series]]"},
             Case{series + "gama = 1\n", "p.toml:2: series.gama: unknown key; did you mean \"gamma\"?"},
             Case{"[point]\nphy = 1\n" + series, "p.toml:2: point.phy: unknown key; did you mean \"phi\"?"},
             Case{series + "gamma = [\"1g\",\n  \"200g\"]\n",
                  "p.toml:3: series.gamma \"200g\": out of range"},
             Case{series + "gamma = \"1x\"\n", "p.toml:2: series.gamma \"1x\": unknown unit \"x\""},
             Case{series + "rho = [0.1, 1.5]\n", "p.toml:2: series.rho: expected a number, 0 to 1, got 1.5"},
             Case{series + "phi = []\n", "p.toml:2: series.phi: expected at least one quantity, got []"},
             Case{series + "phi = [0, 1, 0]\n", "p.toml:2: series.phi: 0 is given twice; repeats = 2"},
             Case{series + "phi = {from = 0, to = 1, steps = 0}\n",
                  "p.toml:2: series.phi.steps: expected a whole number, 1 to 10000, got 0"},
             Case{series + "phi = {from = 0, to = 1}\n", "p.toml:2: series.phi.steps: missing; expected"},
             Case{series + "phi = {from = 0, steps = 1}\n", "p.toml:2: series.phi.to: missing; expected"},
             Case{series + "phi = {from = 0, to = 1, step = 2, steps = 2}\n",
                  "p.toml:2: series.phi.step: unknown key; did you mean \"steps\"?"},
             Case{series + "phi = {from = 1, to = 1, steps = 1}\n", "p.toml:2: series.phi: 1 is given twice"},
             Case{series + "periods = 40\nprecision = \"1mm/s\"\n",
                  "p.toml:3: series.precision: excludes periods; give one of the two"},
             Case{series + "periods = 1\n",
                  "p.toml:2: series.periods: expected a whole number, 3 to 1000000"},
             Case{series + "least_periods = 10\n", "p.toml:2: series.least_periods: needs a precision"},
             Case{series + "precision = 1e-4\nleast_periods = 500\n",
                  "p.toml:3: series.least_periods: least_periods 500 exceeds most_periods 400"},
             Case{series + "order = \"sorted\"\n", "p.toml:2: series.order: expected one of \"listed\""},
             Case{series + "seed = 3\n", "p.toml:2: series.seed: needs order = \"random\""},
             Case{series + "repeats = 0\n", "p.toml:2: series.repeats: expected a whole number, 1 to 10000"},
             Case{series + "order = \"mirror\"\nphi = [\"30deg\", \"210deg\"]\n",
                  "p.toml:3: series.phi: 3.66519 rad is the mirror partner of 0.523599 rad"},
             Case{series + "harmonics = []\n", "p.toml:2: series.harmonics: expected at least one set"},
             Case{series + "harmonics = [{n = 3}]\n", "p.toml:2: series.harmonics: expected tables"},
             Case{series + "harmonics = [[{n = 2, share = 0.1}]]\n",
                  "p.toml:2: series.harmonics.n: expected a whole number, 3 to 8, got 2"},
             Case{series + "harmonics = [[{n = 3}]]\n", "p.toml:2: series.harmonics.share: missing"},
             Case{series + "harmonics = [[{n = 3, share = 0.1}, {n = 3, share = 0.2}]]\n",
                  "p.toml:2: series.harmonics.n: harmonic 3 is given twice"},
             Case{series + "name = \"a\"\n" + series + "name = \"a\"\n",
                  "p.toml:4: series.name: two series have the name \"a\""},
             Case{"mu = 0\n" + series, "p.toml:1: mu: expected a number, 0.001 to 10, got 0"},
             Case{"stop_at = \"mu .2\"\n" + series, "p.toml:1: stop_at: \"mu .2\"; expected \"mu X %\""},
             Case{"stop_at = \"mu 90 %\"\n" + series, "p.toml:1: stop_at: 90 %; 0.001 to 50 % is allowed"},
         })
        EXPECT_TRUE(refusal(c.text).starts_with(c.message)) << refusal(c.text) << "\n" << c.message;
}

}  // namespace
}  // namespace shaker::campaign
