// A flood of events leaves the others, with their names and times.
#include "daemon/service/event_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace shaker::service {
namespace {

struct EventLogTest : testing::Test {
    EventLog log;

    [[nodiscard]] std::vector<BenchEvent> of(const std::string& kind) const {
        std::vector<BenchEvent> list = log.since(0);
        std::erase_if(list, [&](const BenchEvent& e) { return e.kind != kind; });
        return list;
    }
};

TEST_F(EventLogTest, AbortFloodKeepsTripAndFirstName) {
    log.add(10, "order", "start by Ada", "start");
    log.add(20, "trip", "hard stop, acceleration", "acceleration");
    log.add(20.5, "order", "abort by Ada", "abort");
    for (int i = 0; i < 100000; ++i)
        log.add(21 + 1e-4 * i, "order", "abort by 127.0.0.1:" + std::to_string(i), "abort");
    ASSERT_EQ(of("trip").size(), 1U);
    EXPECT_EQ(of("trip")[0].t_s, 20);
    const auto orders = of("order");
    ASSERT_EQ(orders.size(), 2U);
    EXPECT_EQ(orders[0].text, "start by Ada");
    EXPECT_EQ(orders[1].t_s, 20.5);
    EXPECT_EQ(orders[1].text, "abort by Ada (100000 more within 10.5 s, the last: abort by 127.0.0.1:99999)");
}

TEST_F(EventLogTest, SlowFloodKeepsFirstAndNewest) {
    log.add(1, "order", "stop by Ada", "stop");
    for (int i = 0; i < 1000; ++i) log.add(10 + 5 * i, "order", "abort by " + std::to_string(i), "abort");
    const auto orders = of("order");
    ASSERT_EQ(orders.size(), 1 + EventLog::most_alike);
    EXPECT_EQ(orders[0].text, "stop by Ada");
    EXPECT_EQ(orders[1].t_s, 10);
    EXPECT_EQ(orders[1].text, "abort by 0 (992 more within 4960.0 s, the last: abort by 992)");
    EXPECT_EQ(orders.back().text, "abort by 999");
    EXPECT_EQ(orders.back().t_s, 10 + 5 * 999);
}

TEST_F(EventLogTest, OtherKindsAndTextsStay) {
    log.add(1, "trip", "the only one");
    log.add(1, "warning", "the only one");
    for (int i = 0; i < 10000; ++i) {
        log.add(2 + i, "remark", "remark " + std::to_string(i));
        log.add(2 + i, "state", i % 2 == 0 ? "idle" : "tripped");
        log.add(2 + i, "warning", i % 2 == 0 ? "one" : "other");
    }
    EXPECT_EQ(of("trip").size(), 1U);
    EXPECT_EQ(of("warning").size(), 1 + 2 * EventLog::most_alike);
    EXPECT_EQ(of("warning")[0].text, "the only one");
    EXPECT_EQ(of("remark").size(), EventLog::most_rows);
    EXPECT_EQ(of("remark").back().text, "remark 9999");
}

TEST_F(EventLogTest, StatesInQuickTurnKeepTheirOrder) {
    for (const char* state : {"idle", "armed", "idle", "armed", "idle"}) log.add(1, "state", state);
    std::string seen;
    for (const BenchEvent& e : of("state")) seen += e.text + " ";
    EXPECT_EQ(seen, "idle armed idle armed idle ");
}

TEST_F(EventLogTest, ViewerGetsFewRowsAndTheFinalCount) {
    std::uint64_t seen = 0;
    std::size_t got = 0;
    std::string newest;
    const auto look = [&] {
        for (const BenchEvent& e : log.since(seen)) {
            EXPECT_GT(e.number, seen);
            seen = e.number;
            newest = e.text;
            EXPECT_EQ(e.id, 1U) << "the same row";
            ++got;
        }
    };
    for (int i = 0; i < 100000; ++i) {
        log.add(1e-4 * i, "order", "abort by Ada", "abort");
        look();
    }
    log.show_counts(10.5);
    look();
    log.show_counts(11.1);
    look();
    EXPECT_EQ(newest, "abort by Ada (99999 more within 10.0 s)");
    EXPECT_LT(got, 40U);
}

}  // namespace
}  // namespace shaker::service
