#include "daemon/run/walk_prediction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drivers/walker/no_stick.hpp"

namespace shaker::run {
namespace {

Drive at(double gamma, double phi) { return {.frequency = 20, .gamma = gamma, .rho = 0.5, .phi = phi}; }

TEST(WalkPredictionTest, NeedsMuOrAMeasuredPoint) {
    EXPECT_FALSE(predict_walk(at(paper_g, 0), {}, {NAN, NAN}, paper_g));
}

TEST(WalkPredictionTest, ExactLawGivesThePapersDrift) {
    const auto walk = predict_walk(at(2 * paper_g, 0), {}, {0.113, 0}, paper_g);
    ASSERT_TRUE(walk);
    EXPECT_NEAR(walk->v_D.value, 36.5359e-3, 1e-6);
    EXPECT_TRUE(leads_towards(*walk, 1));
    EXPECT_FALSE(leads_towards(*walk, -1));
    const auto back = predict_walk(at(2 * paper_g, std::numbers::pi), {}, {0.113, 0}, paper_g);
    EXPECT_TRUE(leads_towards(*back, -1));
}

TEST(WalkPredictionTest, UncertainMuWidensTheError) {
    const auto known = predict_walk(at(paper_g, 0), {}, {0.113, 0.001}, paper_g),
               vague = predict_walk(at(paper_g, 0), {}, {0.113, 0.1}, paper_g);
    EXPECT_GT(vague->v_D.sigma, 2 * known->v_D.sigma);
}

TEST(WalkPredictionTest, MeasuredPointWinsAndItsMirrorImageCounts) {
    const std::vector<reduction::DrivenPoint> points{{at(paper_g, 1), {paper_g, 0}, {1, 0}, {0.02, 1e-5}}};
    const auto same = predict_walk(at(paper_g, 1), points, {0.113, 0}, paper_g),
               mirror = predict_walk(at(paper_g, 1 - std::numbers::pi), points, {0.113, 0}, paper_g),
               other = predict_walk(at(paper_g, 1.1), points, {0.113, 0}, paper_g);
    EXPECT_EQ(same->v_D.value, 0.02);
    EXPECT_EQ(mirror->v_D.value, -0.02);
    EXPECT_NE(std::abs(other->v_D.value), 0.02);
}

// Near the null phase nobody knows where it will go.
TEST(WalkPredictionTest, NullPhaseLeadsNowhere) {
    double phi = 0.75 * std::numbers::pi, step = 0.125 * std::numbers::pi;
    for (int i = 0; i < 40; ++i, step /= 2)
        phi += predict_walk(at(paper_g, phi), {}, {0.113, 0}, paper_g)->v_D.value > 0 ? step : -step;
    for (const double off : {-0.03, 0.0, 0.03}) {
        const auto walk = predict_walk(at(paper_g, phi + off), {}, {0.113, 0}, paper_g);
        EXPECT_FALSE(leads_towards(*walk, 1)) << walk->v_D.value;
        EXPECT_FALSE(leads_towards(*walk, -1)) << walk->v_D.value;
    }
}

}  // namespace
}  // namespace shaker::run
