// The next point for mu: what it adds for its time, pairs, and when mu is known.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "daemon/campaign/campaign_mu.hpp"
#include "daemon/campaign/plan.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::campaign {
namespace {

constexpr double second(std::span<const Point* const> points) {
    return 5.0 * static_cast<double>(points.size());
}

std::vector<Point> candidates(Order order, int phases = 6) {
    Series s{.name = "s", .frequency = {20}, .rho = {0.5}, .gamma = {0.68 * paper_g, paper_g}};
    for (int i = 0; i < phases; ++i) s.phi.push_back(std::numbers::pi * i / phases);
    s.order = order;
    return schedule({.file = "test", .title = "test", .series = {s}});
}

/// A measured pass of a walker by this law, with an error of v_D of sigma.
law::Point measured(const Point& point, const law::Coulomb& truth, double sigma, std::mt19937_64& random) {
    law::Point p;
    p.number = point.id;
    p.partner = point.partner;
    p.asked = point.asked.drive;
    p.frequency = 20;
    p.base = harmonics(p.asked);
    p.periods = 40;
    p.v_D = {law_point(p, truth).v_D + std::normal_distribution<double>{0, sigma}(random), sigma};
    return p;
}

// In a pair the tilt cancels.
TEST(MuChoiceTest, TakesThePointThatAddsMost) {
    const std::vector<Point> points = candidates(Order::mirror);
    MuChoice choice{1e-3, 0.113, paper_g};
    const std::size_t first = choice.next(points, std::vector<bool>(points.size()), second);
    const auto slope = [&](std::size_t i) {
        law::Point p;
        p.base = harmonics(points[i].asked.drive);
        p.frequency = 20;
        return std::abs(law_point(p, {.mu = 0.113}).by_mu);
    };
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_GE(slope(first), slope(i)) << i;
    // The same information at three times the cost is worth less.
    const std::size_t cheap = choice.next(points, std::vector<bool>(points.size()), [&](auto together) {
        return together[0] == &points[first] ? 15.0 : 5.0;
    });
    EXPECT_NE(cheap, first);
}

TEST(MuChoiceTest, CompletesAPairFirst) {
    const std::vector<Point> points = candidates(Order::mirror);
    MuChoice choice{1e-3, 0.113, paper_g};
    std::vector<bool> over(points.size());
    for (int pair = 0; pair < 3; ++pair) {
        const std::size_t one = choice.next(points, over, second);
        over[one] = true;
        const std::size_t other = choice.next(points, over, second);
        EXPECT_EQ(points[other].id, points[one].partner);
        over[other] = true;
    }
}

TEST(MuChoiceTest, WhatCannotBeMeasuredComesLast) {
    const std::vector<Point> points = candidates(Order::listed);
    MuChoice choice{1e-3, 0.113, paper_g};
    std::vector<bool> over(points.size());
    const auto cost = [&](std::span<const Point* const> together) {
        return together[0]->id <= 3 ? INFINITY : 5.0;
    };
    std::vector<int> order;
    for (std::size_t at = 0; (at = choice.next(points, over, cost)) < points.size();) {
        order.push_back(points[at].id);
        over[at] = true;
    }
    ASSERT_EQ(order.size(), points.size());
    for (std::size_t i = order.size() - 3; i < order.size(); ++i) EXPECT_LE(order[i], 3);
}

// The campaign ends soon, and mu is as near to the truth as it says.
TEST(MuChoiceTest, EndsWhenMuIsKnown) {
    const std::vector<Point> points = candidates(Order::mirror);
    std::mt19937_64 random{3};
    for (const double mu : {0.07, 0.113, 0.2}) {
        const law::Coulomb truth{.mu = mu, .tilt = 1e-3};
        MuChoice choice{2e-3, 0.113, paper_g};
        std::vector<bool> over(points.size());
        std::vector<law::Point> passes;
        for (std::size_t at = 0; (at = choice.next(points, over, second)) < points.size();) {
            passes.push_back(measured(points[at], truth, 5e-6, random));
            choice.add(passes.back());
            over[at] = true;
        }
        EXPECT_TRUE(choice.reached()) << choice.sentence();
        EXPECT_LE(passes.size(), 8U);
        const law::Fit found = law::fit_coulomb(passes).mu;
        EXPECT_LE(found.error, 2e-3 * mu);
        EXPECT_NEAR(found.value, mu, 4 * found.error) << choice.sentence();
        choice.forget(passes.front().number);
        choice.forget(passes.back().number);
        over.assign(points.size(), true);
        EXPECT_EQ(choice.next(points, over, second), points.size());
    }
}

// A viscous walker: its points give Coulomb's law a mu to 0.2 %, and refuse it. More of them would not help.
TEST(MuChoiceTest, PassesThatRefuseTheLawEndWithoutMu) {
    const std::vector<Point> points = candidates(Order::mirror, 8);
    std::mt19937_64 random{3};
    MuChoice choice{2e-3, 0.113, paper_g};
    std::vector<bool> over(points.size());
    std::size_t passes = 0;
    for (std::size_t at = 0; (at = choice.next(points, over, second)) < points.size(); ++passes) {
        law::Point p = measured(points[at], {.mu = 0.113}, 5e-6, random);
        walker::WalkerSetting setting = walker::coulomb(p.asked, 0.113, paper_g);
        setting.friction.viscous = 3.5;
        p.v_D.value = walker::settle(setting).v_D;
        choice.add(p);
        over[at] = true;
    }
    EXPECT_GE(passes, 12U);
    EXPECT_LE(passes, 14U);
    EXPECT_FALSE(choice.reached());
    EXPECT_NE(choice.sentence().find("mu is not known: chi^2 is"), std::string::npos) << choice.sentence();
}

TEST(MuChoiceTest, SaysWhyMuIsNotKnown) {
    const std::vector<Point> points = candidates(Order::listed, 1);
    MuChoice choice{2e-3, 0.113, paper_g};
    std::mt19937_64 random{3};
    choice.add(measured(points[0], {}, 5e-6, random));
    choice.next(points, {true, true}, second);
    EXPECT_FALSE(choice.reached());
    EXPECT_NE(choice.sentence().find("at least 3 are needed"), std::string::npos) << choice.sentence();
}

}  // namespace
}  // namespace shaker::campaign
