// The points table of a campaign from recordings of the bench on call: from their results, and computed
// again.
#include "daemon/campaign/point_results.hpp"

#include <gtest/gtest.h>

#include <random>

#include "daemon/campaign/combined_passes.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::campaign {
namespace {

using service::Begin;
using service::BenchState;
using test::in;
using test::measured;
using test::orders;

constexpr int periods = 10;

Drive other_drive() {
    Drive other;
    other.gamma = 8;
    other.phi = 1.2;
    other.overtones[0] = {0.05, 0.02};
    return other;
}

// Two measurements of one set-point, then one of another.
test::OnCallResult record(const std::filesystem::path& folder, const char* scene,
                          recorded::KeptPictures pictures) {
    test::Answers answers;
    run::RunOptions options = test::quick();
    options.pictures = pictures;
    auto r =
        test::play_on_call(scene, options, folder,
                           {{in(run::RunState::idle), orders(service::Record{true, "r1", pictures}, answers)},
                            {in(run::RunState::idle), orders(Begin{periods}, answers)},
                            {measured(2), orders(service::SetDrive{other_drive()}, answers)},
                            {measured(3), orders(service::End{}, answers)},
                            test::until(in(run::RunState::idle))});
    EXPECT_EQ(answers, test::Answers(4, ""));
    return r;
}

std::vector<PointRow> asked_points() {
    PointRow first{.point = 1, .series = "a", .partner = 2}, second = first, third = first;
    second.point = 2;
    second.partner = 1;
    second.asked = other_drive();
    third.point = 3;
    return {first, second, third};
}

PassEnded pass(int point, int number, int measurement) {
    PassEnded p{.point = point, .pass = number, .recording = "r1", .measurement = measurement};
    p.x_from_m = 0.001 * number;
    p.x_to_m = 0.001 * number + 0.01;
    p.true_v_D = 0.01 * measurement;
    return p;
}

Progress two_points(const PointEnded& second = {2, Outcome::measured, ""}) {
    Progress p;
    p.points[1] = {.begun = 1, .passes = {pass(1, 1, 1), pass(1, 2, 2)}, .ended = PointEnded{1}};
    p.points[2] = {.begun = 2, .passes = {pass(2, 1, 3)}, .ended = second};
    return p;
}

class PointResultsTest : public testing::Test {
protected:
    [[nodiscard]] PointResults results(const Progress& progress, Source source = Source::stored) const {
        return point_results(folder_, asked_points(), progress, source);
    }
    const std::filesystem::path folder_ = test::fresh_folder();
};

TEST_F(PointResultsTest, ComputedAgainEqualsStored) {
    const auto r = record(folder_, test::slow, recorded::KeptPictures::off);
    const PointResults stored = results(two_points()), again = results(two_points(), Source::raw);
    EXPECT_EQ(testing::PrintToString(differences(stored.table, again.table)), "{}");
    EXPECT_TRUE(stored.remarks.empty());
    ASSERT_EQ(again.remarks.size(), 1U);
    EXPECT_NE(again.remarks[0].find("positions of the cameras"), std::string::npos) << again.remarks[0];
    write_points(folder_ / "campaign.nxs", "title", "plan", stored.table);
    EXPECT_EQ(testing::PrintToString(differences(read_points(folder_ / "campaign.nxs"), again.table)), "{}");

    ASSERT_EQ(stored.table.points.size(), 3U);
    const PointRow &one = stored.table.points[0], &two = stored.table.points[1];
    EXPECT_EQ(two.outcome, "measured");
    EXPECT_EQ(two.measurement, 3);
    EXPECT_EQ(two.recording, "r1");
    EXPECT_EQ(two.periods, periods);
    EXPECT_EQ(two.begun, 2);
    EXPECT_EQ(two.passes, 1);
    EXPECT_NEAR(two.gamma.value, 8, 0.02);
    EXPECT_NEAR(two.phi.value, 1.2, 0.01);
    EXPECT_NEAR(two.true_v_D, 0.03, 1e-15);
    const reduction::DrivenPoint& live = r.last.points.at(2);
    EXPECT_NEAR(two.v_D.value, live.v_D.value, live.v_D.sigma);

    EXPECT_EQ(one.passes, 2);
    EXPECT_EQ(one.periods, 2 * periods);
    EXPECT_NEAR(one.travel_m, 0.02, 1e-12);
    EXPECT_GE(one.chi2, 0);
    const auto& [a, b] = std::pair{r.last.points.at(0).v_D, r.last.points.at(1).v_D};
    EXPECT_GT(one.v_D.value, std::min(a.value, b.value) - 0.1 * a.sigma);
    EXPECT_LT(one.v_D.value, std::max(a.value, b.value) + 0.1 * a.sigma);
    EXPECT_LT(one.v_D.sigma, std::max(a.sigma, b.sigma) * std::max(1.0, std::sqrt(one.chi2)));
}

TEST_F(PointResultsTest, RowsHaveHarmonicsCycleAndSticks) {
    record(folder_, test::slow, recorded::KeptPictures::off);
    const PointsTable t = results(two_points()).table;
    ASSERT_EQ(t.harmonics.size(), 3U * max_harmonics);
    const PointHarmonic& third = t.harmonics[max_harmonics + 2];
    EXPECT_EQ(third.measured.q, 3);
    EXPECT_NEAR(third.asked, 8 * std::hypot(0.05, 0.02), 1e-12);
    EXPECT_NEAR(third.measured.amplitude.value, third.asked, 0.02);
    ASSERT_EQ(t.cycle.size(), 3U * cycle_phases);
    double mean = 0;
    for (std::size_t k = 0; k < cycle_phases; ++k) mean += t.cycle[k].v_mps / cycle_phases;
    EXPECT_NEAR(mean, t.points[0].v_D.value, 0.05 * t.points[0].v_rms.value)
        << "v(t) has the drift as its mean";
    EXPECT_EQ(t.cycle[0].x_m, 0);
    EXPECT_TRUE(std::isnan(t.cycle[2 * cycle_phases].v_mps)) << "not begun";
    EXPECT_EQ(t.points[2].outcome, "not begun");
    EXPECT_TRUE(std::isnan(t.points[2].v_D.value));
    EXPECT_EQ(t.passes.size(), 3U);
}

TEST_F(PointResultsTest, PointWithoutResultsIsNotMeasured) {
    record(folder_, test::slow, recorded::KeptPictures::off);
    Progress p = two_points({2, Outcome::failed, "a trip"});
    p.points[1].passes[1].measurement = 9;
    p.points[3] = {.begun = 1, .passes = {pass(3, 1, 1)}, .ended = PointEnded{3}};
    p.points[3].passes[0].recording = "r2";
    const PointResults out = results(p);
    EXPECT_EQ(out.table.points[0].outcome, "measured") << "by its other pass";
    EXPECT_EQ(out.table.points[0].passes, 1);
    EXPECT_EQ(out.table.points[1].outcome, "failed");
    EXPECT_EQ(out.table.points[1].reason, "a trip");
    EXPECT_TRUE(std::isnan(out.table.points[1].v_D.value)) << "its pass is in the table of passes only";
    EXPECT_GT(std::abs(out.table.passes[2].v_D.value), 0);
    EXPECT_EQ(out.table.points[2].outcome, "failed");
    EXPECT_NE(out.table.points[2].reason.find("r2.nxs does not exist"), std::string::npos);
    ASSERT_EQ(out.lost.size(), 2U);
    EXPECT_EQ(out.lost[0].point, 1);
    EXPECT_EQ(out.lost[0].pass, 2);
    EXPECT_NE(out.lost[0].reason.find("measurement 9 of r1.nxs"), std::string::npos) << out.lost[0].reason;
    EXPECT_EQ(out.remarks.size(), 2U);
    std::ofstream{folder_ / "r2.nxs.part"} << "torn";
    EXPECT_NE(results(p).lost[1].reason.find("shakerd recover"), std::string::npos);
}

// 200 campaigns of 24 points whose errors differ by a factor of three, one point in half of them of another
// sensor.
TEST(OtherCornersTest, OnlyThePointOfAnotherSensorIsInDoubt) {
    std::mt19937_64 random{11};
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    int named = 0, wrong = 0;
    for (int i = 0; i < 200; ++i) {
        const double hz = uniform(random), error = 0.003 + 0.01 * uniform(random);
        const auto other = static_cast<std::size_t>(24 * uniform(random));
        std::vector<PointRow> rows(24);
        for (PointRow& row : rows) {
            const double own = error * (1 + 2 * uniform(random));
            row.corner = {hz + own * normal(random), own};
        }
        if (i % 2 == 0) rows[other].corner.value += 30 * error;
        name_other_corners(rows);
        for (std::size_t k = 0; k < rows.size(); ++k)
            (i % 2 == 0 && k == other ? named : wrong) += !rows[k].doubt.empty();
    }
    EXPECT_EQ(named, 100);
    EXPECT_EQ(wrong, 0);
    std::vector<PointRow> few{{.corner = {0.3, 0.001}}, {.corner = {0.5, 0.001}}, {.corner = {0.1, 0.001}}};
    few.push_back({.corner = {9, 0.001}, .doubt = "as before"});
    name_other_corners(few);
    EXPECT_EQ(few[3].doubt, "as before");
    EXPECT_NE(few[0].doubt.find("0.3000 +- 0.0010 Hz here"), std::string::npos) << few[0].doubt;
    few.pop_back();
    few[0].doubt.clear();
    name_other_corners(few);
    EXPECT_EQ(few[0].doubt, "") << "of three points nobody knows which is the other";
}

// Pictures are tracked again when all were kept; otherwise the stored tracks are used, and the remark has the
// reason.
TEST_F(PointResultsTest, SourceIsNamed) {
    for (const auto& [kept, words] : {std::pair{recorded::KeptPictures::off, "no pictures were kept"},
                                      {recorded::KeptPictures::region, "from pictures"}}) {
        std::filesystem::remove(folder_ / "r1.nxs");
        record(folder_, test::rendered, kept);
        const PointResults again = results(two_points(), Source::raw);
        EXPECT_NE(again.remarks.at(0).find(words), std::string::npos) << again.remarks[0];
        EXPECT_EQ(testing::PrintToString(differences(results(two_points()).table, again.table)), "{}");
    }
}

}  // namespace
}  // namespace shaker::campaign
