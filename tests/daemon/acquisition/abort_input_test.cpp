// The abort input: an open, unreadable or unread contact is a hard stop, and nothing re-arms while it is
// open.
#include <gtest/gtest.h>

#include "daemon/acquisition/drive_output.hpp"
#include "daemon/acquisition/steps.hpp"
#include "drivers/devices.hpp"
#include "tests/support/devices/queued_dac.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::acquisition {
namespace {

using safety::Cause;

class FakeContact final : public AbortInput {
public:
    explicit FakeContact(Contact& state) : state_{state} {}
    [[nodiscard]] Contact read(std::chrono::milliseconds /*wait*/) noexcept override { return state_; }

private:
    Contact& state_;
};

struct Output {
    Output() {
        rig.abort_input = std::make_unique<FakeContact>(contact);
        output.has_contact = rig.abort_input != nullptr;
        trips.reserve(16);
        for (auto* all : {&dac.given, &dac.triggers}) all->reserve(1 << 20);
        dac.tone.reserve(1 << 20);
    }
    void go(int blocks) {
        for (int i = 0; i < blocks; ++i) {
            if (reads) abort_input_step(*rig.abort_input, {}, channels);
            output_step(output, dac, channels);
            while (channels.changes.pop()) {
            }
            while (channels.played.pop()) {
            }
            while (const auto t = channels.trips.pop()) trips.push_back(*t);
        }
    }
    void drive() {
        DriveCommand c;
        c.volts.at(1) = 0.5;
        channels.drive.post(c);
        go(60);
        ASSERT_FALSE(channels.stopped);
        ASSERT_NE(dac.given.back(), 0);
    }
    void accept_clear() {
        channels.clearance.post(
            {trips.empty() ? 0 : trips.back().number, channels.aborts, channels.openings});
    }
    /// Opens and closes between two blocks.
    void open_briefly() {
        for (const Contact state : {Contact::open, Contact::closed}) {
            contact = state;
            abort_input_step(*rig.abort_input, {}, channels);
        }
    }
    void clear() {
        accept_clear();
        go(2);
    }
    void expect_hard_trip(std::size_t count) {
        ASSERT_EQ(trips.size(), count);
        EXPECT_EQ(trips.back().cause, Cause::abort_input);
        EXPECT_EQ(trips.back().stop, safety::StopKind::hard);
        EXPECT_TRUE(channels.stopped);
        EXPECT_EQ(dac.given.back(), 0);
    }
    test::QueuedDac dac{2400, 480};
    Channels channels{0};
    DriveOutput output{dac.info(), 20, 0, 240};
    Contact contact = Contact::closed;
    Rig rig;
    bool reads = true;
    std::vector<safety::Trip> trips;
};

TEST(AbortInputTest, OpenOrUnreadableContactIsAHardStop) {
    for (const Contact state : {Contact::open, Contact::unreadable}) {
        Output run;
        run.drive();
        run.contact = state;
        run.go(1);
        EXPECT_GT(run.dac.taken_back, 0) << "in the block after the reading";
        run.go(10);
        run.expect_hard_trip(1);
    }
}

TEST(AbortInputTest, BriefOpeningLatches) {
    Output run;
    run.drive();
    run.contact = Contact::open;
    abort_input_step(*run.rig.abort_input, {}, run.channels);
    run.contact = Contact::closed;
    run.go(20);
    run.expect_hard_trip(1);
    run.clear();
    EXPECT_FALSE(run.channels.stopped);
    EXPECT_EQ(run.dac.given.back(), 0) << "a clear drives nothing";
}

TEST(AbortInputTest, ContactThatIsNotReadStops) {
    Output run;
    run.drive();
    run.reads = false;
    run.go(39);
    EXPECT_TRUE(run.trips.empty());
    run.go(10);
    run.expect_hard_trip(1);
    run.reads = true;
    run.go(100);
    run.clear();
    EXPECT_FALSE(run.channels.stopped);
}

TEST(AbortInputTest, LongUnderrunIsNoUnreadContact) {
    Output run;
    run.drive();
    run.dac.loses = 24000;
    run.go(20);
    EXPECT_TRUE(run.trips.empty());
}

TEST(AbortInputTest, NoClearWhileTheContactIsOpen) {
    Output run;
    run.drive();
    run.contact = Contact::open;
    run.go(100);
    run.expect_hard_trip(1);
    run.clear();
    run.expect_hard_trip(2);
    run.contact = Contact::closed;
    run.go(100);
    EXPECT_TRUE(run.channels.stopped) << "a contact that closes re-arms nothing";
    run.clear();
    EXPECT_FALSE(run.channels.stopped);
    run.drive();
}

TEST(AbortInputTest, OpenFromTheStartLatchesAtRest) {
    Output run;
    run.contact = Contact::open;
    run.go(3);
    run.expect_hard_trip(1);
    run.go(100);
    EXPECT_EQ(run.trips.size(), 1U);
}

TEST(AbortInputTest, ChatterWhileLatchedLeavesOneTrip) {
    Output run;
    run.drive();
    for (int i = 0; i < 1000; ++i) {
        run.open_briefly();
        run.go(2);
    }
    run.expect_hard_trip(1);
    run.clear();
    EXPECT_FALSE(run.channels.stopped);
    run.open_briefly();
    run.go(10);
    run.expect_hard_trip(2);
}

TEST(AbortInputTest, OpeningVoidsAClearThatWaits) {
    Output run;
    run.drive();
    run.open_briefly();
    run.go(10);
    run.expect_hard_trip(1);
    run.accept_clear();
    run.open_briefly();
    run.go(10);
    run.expect_hard_trip(2);  // the reduction waits for an answer
    run.open_briefly();
    run.accept_clear();
    run.go(10);
    EXPECT_FALSE(run.channels.stopped) << "the contact was closed again before the clear";
}

TEST(AbortInputTest, ChatterAfterAnAbortLeavesItsTrip) {
    Output run;
    run.drive();
    ++run.channels.aborts;
    run.go(10);
    ASSERT_EQ(run.trips.size(), 1U);
    for (int i = 0; i < 10; ++i) {
        run.open_briefly();
        run.go(2);
    }
    run.expect_hard_trip(2);
}

TEST(AbortInputTest, DoesNotAllocate) {
    Output run;
    const test::NoAlloc guard;
    run.drive();
    run.contact = Contact::open;
    run.go(20);
}

}  // namespace
}  // namespace shaker::acquisition
