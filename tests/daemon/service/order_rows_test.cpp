// The table of orders against the bench: which order is accepted at rest, in a run, after a trip, in a
// campaign.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/campaign/lead/plans.hpp"
#include "daemon/orders/rows.hpp"
#include "daemon/service/made_order.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::in;

OrderWhat an_order(const orders::Row& row, const BenchState& state) {
    orders::Values v{row};
    if (row.name == "targets") {
        const View& view = state.facts->views.front();
        const Target& target = view.targets.front();
        MoveTargets moved{{{view.camera, target.name, {}}}};
        for (std::size_t i = 0; i < 4; ++i) moved.targets[0].roi_px[i] = target.roi_px[i];
        return moved;
    }
    if (row.name == "drive") v.add_text("gamma_mps2", "0.9 g");
    if (row.name == "mu") v.add_number("mu", 0.12);
    if (row.name == "remark") v.add_text("text", "a remark");
    if (row.name == "loop") v.add_flag("closed", true);
    if (row.name == "record") v.add_text("name", "walk");
    if (row.name == "limit") {
        v.add_text("limit", "transverse");
        v.add_text("value", "0.45");
    }
    if (row.name == "campaign" || row.name == "campaign/check") {
        v.add_text("scan", "phi");
        v.add_text("from", "0 deg");
        v.add_text("to", "180 deg");
        v.add_number("steps", 2);
        v.add_number("periods", 10);
    }
    return made(v, {.drive = state.wanted, .limits = state.limits, .run = {state.plan}});
}

struct Situation {
    const char* name;
    std::vector<test::Move> before;
    bool (*accepted)(const orders::When& when);
};

class OrderRowsTest : public test::OnCallBench {
protected:
    /// The order is given where the moves lead; empty: accepted.
    std::string answer_to(const orders::Row& row, std::vector<test::Move> before) {
        const std::string scene = std::string{row.name == "targets" ? test::rendered : test::slow}.append(
            "[walker]\nstart_mm = 25\n");
        std::optional<std::string> told;
        before.back().act = [&](BenchPort& port) {
            OrderWhat order = an_order(row, *port.state());
            const bool a_word = std::holds_alternative<TellCampaign>(order);
            EXPECT_EQ(row_of(order).name, a_word ? "campaign/pause" : row.name);
            port.order({std::move(order), [&](const std::string& refused) { told = refused; }});
        };
        before.push_back(test::until([&](const BenchState&) { return told.has_value(); }));
        const std::filesystem::path own = folder / std::to_string(++played_);
        std::filesystem::create_directory(own);
        const auto r = test::play_on_call(scene, options, own, std::move(before), 60, {0.113, 0.001});
        return told.value_or("no answer: " + test::log_of(r));
    }
    int played_ = 0;
    std::vector<Situation> situations(std::string_view order) {
        const auto nothing = [](BenchPort&) {};
        const test::Move stopped{in(RunState::run), [](BenchPort& port) { port.abort("a test"); }};
        const test::Move campaign{
            in(RunState::idle), give(MeasurePlan{"scan", campaign::text_of({.to = std::numbers::pi,
                                                                            .steps = 2,
                                                                            .rest = {.gamma = 0.7 * paper_g},
                                                                            .periods = 40})})};
        const auto measures = [again = order == "campaign/repeat"](const BenchState& s) {
            return s.campaign && s.campaign->active && s.measuring && (!again || s.campaign->ended > 0);
        };
        const test::Move paused{[](const BenchState& s) { return s.campaign && s.campaign->paused; },
                                nothing};
        const auto seen = [](const BenchState& s) { return s.state == RunState::idle && s.walker; };
        return {{"at rest", {{seen, nothing}}, [](const orders::When& w) { return w.at_rest; }},
                {"driven",
                 {start(), {in(RunState::run), nothing}},
                 [](const orders::When& w) { return w.driven; }},
                {"tripped",
                 {start(), stopped, {test::may_clear, nothing}},
                 [](const orders::When& w) { return w.tripped; }},
                {"in a campaign",
                 order == "campaign/resume" ? std::vector{campaign, test::Move{measures, give(End{})}, paused}
                                            : std::vector{campaign, test::Move{measures, nothing}},
                 [](const orders::When& w) {
                     const bool of_campaign = !w.at_rest && !w.driven && !w.tripped;
                     return w.not_in_campaign.empty() && (w.driven || of_campaign);
                 }}};
    }
};

TEST_F(OrderRowsTest, ATruthTableOfEachOrderAndSituation) {
    for (const orders::Row& row : orders::rows())
        for (const Situation& situation : situations(row.name)) {
            std::vector<test::Move> before = situation.before;
            const std::string refused = answer_to(row, std::move(before));
            EXPECT_EQ(refused.empty(), situation.accepted(row.when))
                << row.name << ' ' << situation.name << ": " << refused;
        }
}

TEST(OrderRowTest, EveryStartMayDriveAndIsVoidedByAnAbort) {
    for (const orders::Row& row : orders::rows()) {
        EXPECT_TRUE(!row.when.starts || row.when.may_drive) << row.name;
        EXPECT_FALSE(row.when.may_drive && row.when.outlasts_abort) << row.name;
        EXPECT_FALSE(row.when.may_drive && row.when.overtakes) << row.name;
    }
}

TEST(OrderRowTest, RowsBelongToTheirOrders) {
    EXPECT_EQ(row_of(End{}).name, "stop");
    EXPECT_EQ(row_of(MoveTargets{}).name, "targets");
    EXPECT_EQ(row_of(TellCampaign{campaign::Word::stop}).when.not_in_campaign, "");
    EXPECT_EQ(row_of(Adopt{}).name, "");
    for (const orders::Row& row : orders::rows()) EXPECT_EQ(orders::find(row.name), &row);
}

}  // namespace
}  // namespace shaker::service
