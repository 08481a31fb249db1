// The mu of the predictions starts with that of the plan and follows the points.
#include <gtest/gtest.h>

#include <numbers>

#include "daemon/campaign/campaign_mu.hpp"

namespace shaker::campaign {
namespace {

constexpr int most_settling = 60;

Drive drive(double gamma_g, double phi) {
    return {.frequency = 20, .gamma = gamma_g * paper_g, .rho = 0.5, .phi = phi};
}

TEST(LearnedMuTest, PointsLeadFromAWrongMuToTheirs) {
    WalkPredictor truth{0.09, paper_g, most_settling};
    LearnedMu learned{0.14, paper_g, most_settling};
    for (const auto& [gamma, phi] : {std::pair{1.0, 0.0}, {1.0, std::numbers::pi}, {0.7, 0.5}, {2.0, 0.3}})
        learned.add(drive(gamma, phi), {truth.at(drive(gamma, phi)).v_D, 1e-6});
    EXPECT_NEAR(learned.value(), 0.09, 0.02 * 0.09);
    EXPECT_NEAR(learned.walk(drive(3, 0)).v_D, truth.at(drive(3, 0)).v_D, 5e-4);
}

TEST(LearnedMuTest, AgreementAndUnknownResultsChangeNothing) {
    WalkPredictor truth{0.113, paper_g, most_settling};
    LearnedMu learned{0.113, paper_g, most_settling};
    learned.add(drive(1, 0), {1.001 * truth.at(drive(1, 0)).v_D, 1e-6});
    learned.add(drive(1, 1), {NAN, NAN});
    EXPECT_EQ(learned.value(), 0.113);
}

// A walker that follows no law of the list: its own drift is the prediction, also for the mirror image.
TEST(LearnedMuTest, AMeasuredWalkIsPredictedAsMeasured) {
    LearnedMu learned{0.113, paper_g, most_settling};
    const double by_law = learned.walk(drive(1, 0.4)).v_D;
    learned.add(drive(1, 0.4), {0.6 * by_law, 1e-6});
    EXPECT_EQ(learned.walk(drive(1, 0.4)).v_D, 0.6 * by_law);
    EXPECT_EQ(learned.walk(drive(1, 0.4 + std::numbers::pi)).v_D, -0.6 * by_law);
    EXPECT_GT(learned.walk(drive(1, 0.4)).settling, 0);
    EXPECT_EQ(learned.prediction(drive(1, 0.4)).from, "measured before at this set-point");
    EXPECT_NE(learned.prediction(drive(1, 0.5)).from.find("Coulomb's law with mu"), std::string::npos);
}

// A point with a wrong drift changes mu by 30 % at most.
TEST(LearnedMuTest, OneStepIsLimited) {
    LearnedMu learned{0.113, paper_g, most_settling};
    learned.add(drive(1, 0), {-0.05, 1e-6});
    EXPECT_GE(learned.value(), 0.7 * 0.113 - 1e-12);
    EXPECT_LE(learned.value(), 1.3 * 0.113 + 1e-12);
}

}  // namespace
}  // namespace shaker::campaign
