// The watchdog is fed while all threads are alive or at rest.
#include "daemon/service/heartbeats.hpp"

#include <gtest/gtest.h>

namespace shaker::service {
namespace {

using std::chrono::milliseconds;

class HeartbeatsTest : public testing::Test {
protected:
    // Name of the overdue thread this long after the start; empty without one.
    std::string overdue(int ms) {
        const Heartbeat* late = beats_.overdue(begin_ + milliseconds{ms});
        return late == nullptr ? "" : late->name();
    }
    Heartbeats beats_;
    Heartbeat& output_ = beats_.add("output", milliseconds{500});
    Heartbeat& doors_ = beats_.add("doors", milliseconds{1000});
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

TEST_F(HeartbeatsTest, NothingIsExpectedBeforeTheFirstBeat) {
    EXPECT_EQ(overdue(0), "");
    EXPECT_EQ(overdue(60'000), "");
}

TEST_F(HeartbeatsTest, SilentThreadIsNamed) {
    output_.beat();
    doors_.beat();
    EXPECT_EQ(overdue(0), "");
    EXPECT_EQ(overdue(500), "");
    EXPECT_EQ(overdue(501), "output");
    output_.beat();
    EXPECT_EQ(overdue(990), "");
    output_.beat();
    EXPECT_EQ(overdue(1001), "doors") << "the other thread alone does not feed the watchdog";
    doors_.beat();
    EXPECT_EQ(overdue(1010), "");
}

TEST_F(HeartbeatsTest, ThreadAtRestIsAlive) {
    output_.beat();
    EXPECT_EQ(overdue(0), "");
    output_.rest();
    EXPECT_EQ(overdue(5000), "");
    output_.beat();
    EXPECT_EQ(overdue(5400), "") << "counted from the last look";
    EXPECT_EQ(overdue(5901), "output");
}

}  // namespace
}  // namespace shaker::service
