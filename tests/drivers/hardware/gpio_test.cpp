// Enable output and abort input on lines of a test: toggling, its end, the contact, and the tables of a rig
// file.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <thread>

#include "drivers/errors.hpp"
#include "drivers/hardware/gpio/contact_input.hpp"
#include "drivers/hardware/gpio/pulsed_output.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::gpio {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// What the line saw; outlives it.
struct Seen {
    std::atomic<int> edges{0};
    std::atomic<bool> high{false}, gone{false};
    std::atomic<Clock::rep> last{0};
    [[nodiscard]] Clock::time_point last_edge() const { return Clock::time_point{Clock::duration{last}}; }
};

class FakeOutput final : public OutputLine {
public:
    explicit FakeOutput(Seen& seen) : seen_{seen} {}
    [[nodiscard]] bool set(bool high) noexcept override {
        if (seen_.gone) return false;
        if (seen_.high.exchange(high) != high) {
            ++seen_.edges;
            seen_.last = Clock::now().time_since_epoch().count();
        }
        return true;
    }

private:
    Seen& seen_;
};

const EnableSettings quick{.at = {"fake", "1"}, .toggle_hz = 250, .hold_s = 0.1, .fifo_priority = 0};

/// The blocks of an output thread: one each 5 ms for `s`.
void feed(PulsedOutput& output, bool on, double s) {
    for (int i = 0; i < static_cast<int>(s / 0.005); ++i) {
        output.feed(on);
        std::this_thread::sleep_for(milliseconds{5});
    }
}

TEST(GpioEnableTest, TogglesOnlyWhileDriving) {
    Seen seen;
    PulsedOutput output{std::make_unique<FakeOutput>(seen), quick};
    feed(output, false, 0.1);
    EXPECT_EQ(seen.edges, 0);
    feed(output, true, 0.4);
    const int edges = seen.edges;
    if (test::in_real_time) {
        EXPECT_GT(edges, 100);
        EXPECT_LT(edges, 300);
    }
    feed(output, false, 0.05);
    const int ended = seen.edges;
    feed(output, false, 0.1);
    EXPECT_EQ(seen.edges, ended);
    EXPECT_FALSE(seen.high) << "it rests low";
}

TEST(GpioEnableTest, StopsInTimeWhenTheOutputHangs) {
    Seen seen;
    PulsedOutput output{std::make_unique<FakeOutput>(seen), quick};
    feed(output, true, 0.2);
    output.feed(true);
    const Clock::time_point hung = Clock::now();
    std::this_thread::sleep_for(milliseconds{300});
    const double s = std::chrono::duration<double>(seen.last_edge() - hung).count();
    std::printf("last edge %.1f ms after the last block\n", 1e3 * s);
    const int ended = seen.edges;
    std::this_thread::sleep_for(milliseconds{50});
    EXPECT_EQ(seen.edges, ended);
    EXPECT_FALSE(seen.high);
    if (!test::in_real_time) return;
    EXPECT_GT(s, 0.08) << "the ramp in the DAC's buffer is played first";
    EXPECT_LT(s, 0.12);
}

TEST(GpioEnableTest, StopsWithItsOwner) {
    Seen seen;
    {
        PulsedOutput output{std::make_unique<FakeOutput>(seen), quick};
        feed(output, true, 0.05);
    }
    EXPECT_FALSE(seen.high);
}

TEST(GpioEnableTest, ChipThatIsGoneStopsNothingElse) {
    Seen seen;
    PulsedOutput output{std::make_unique<FakeOutput>(seen), quick};
    feed(output, true, 0.05);
    seen.gone = true;
    feed(output, true, 0.05);
    seen.gone = false;
    const int edges = seen.edges;
    feed(output, true, 0.1);
    EXPECT_GT(seen.edges, edges);
}

TEST(GpioEnableTest, FeedingDoesNotAllocate) {
    Seen seen;
    PulsedOutput output{std::make_unique<FakeOutput>(seen), quick};
    const test::NoAlloc guard;
    for (int i = 0; i < 100; ++i) output.feed(i % 2 == 0);
}

class FakeInput final : public InputLine {
public:
    explicit FakeInput(std::optional<Levels>& levels) : levels_{levels} {}
    [[nodiscard]] std::optional<Levels> watch(milliseconds /*wait*/) noexcept override { return levels_; }

private:
    std::optional<Levels>& levels_;
};

TEST(GpioAbortTest, ContactIsClosedAtItsLevelOnly) {
    for (const bool closed_high : {false, true}) {
        std::optional<InputLine::Levels> levels{{.high = closed_high}};
        ContactInput input{std::make_unique<FakeInput>(levels),
                           {.at = {"fake", "2"}, .closed_high = closed_high}};
        EXPECT_EQ(input.read({}), Contact::closed);
        levels->high = !closed_high;
        EXPECT_EQ(input.read({}), Contact::open);
        *levels = {.high = closed_high, .was_high = true, .was_low = true};
        EXPECT_EQ(input.read({}), Contact::open) << "it opened and closed between two readings";
        *levels = {.high = closed_high, .was_high = closed_high, .was_low = !closed_high};
        EXPECT_EQ(input.read({}), Contact::closed);
        levels.reset();
        EXPECT_EQ(input.read({}), Contact::unreadable);
        levels = {.high = closed_high};
        EXPECT_EQ(input.read({}), Contact::closed);
    }
}

TEST(GpioSettingsTest, ReadsAndRefuses) {
    const auto table = [](const std::string& text) { return SettingsTable::from_text(text, "rig.toml"); };
    const std::string at = "chip = 'gpiochip0'\nline = '17'\n";
    SettingsTable enable = table(at + "toggle_hz = 100\nbefore_s = 0.5\nhold_s = 0.2");
    const EnableSettings e = read_enable(enable);
    enable.finish();
    EXPECT_EQ(e.at, (LineName{"gpiochip0", "17"}));
    EXPECT_EQ(e.toggle_hz, 100);
    EXPECT_EQ(e.before_s, 0.5);
    EXPECT_EQ(e.hold_s, 0.2);
    SettingsTable abort = table(at + "pull = 'down'");
    EXPECT_TRUE(read_abort(abort).closed_high);
    abort = table(at);
    EXPECT_FALSE(read_abort(abort).closed_high) << "a broken wire is pulled up: open";
    const auto said = [&](const std::string& text) -> std::string {
        try {
            SettingsTable t = table(text);
            read_abort(t);
        } catch (const InputError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_NE(said(at + "closed = 'high'").find("a broken wire would read as a closed contact"),
              std::string::npos);
    EXPECT_NE(said(at + "pull = 'down'\nclosed = 'low'").find("rig.toml:4"), std::string::npos);
    EXPECT_EQ(said(at + "pull = 'off'\nclosed = 'high'"), "accepted") << "a resistor outside";
    EXPECT_NE(said("chip = 'gpiochip0'").find("line"), std::string::npos);
}

TEST(GpioSettingsTest, LineNumberOutOfRangeIsRefused) {
    EXPECT_EQ(line_number({"gpiochip0", "0"}, 54), 0U);
    EXPECT_EQ(line_number({"gpiochip0", "53"}, 54), 53U);
    for (const char* name : {"GPIO17", "17a", "-1"})
        EXPECT_EQ(line_number({"gpiochip0", name}, 54), std::nullopt) << name << " is a name";
    for (const std::string number : {"54", "99999", "4294967296", "99999999999999999999"}) try {
            line_number({"gpiochip0", number}, 54);
            ADD_FAILURE() << number;
        } catch (const DeviceError& e) {
            EXPECT_EQ(std::string{e.what()}, "GPIO line " + number +
                                                 " of gpiochip0: no such line; expected a name of gpioinfo "
                                                 "or a number from 0 to 53");
        }
}

TEST(GpioSettingsTest, UnknownChipIsNamed) {
    try {
        chip_lines.output({"no_such_chip", "3"});
        FAIL();
    } catch (const DeviceError& e) {
        EXPECT_NE(std::string{e.what()}.find("GPIO line 3 of no_such_chip: the chip cannot be opened"),
                  std::string::npos)
            << e.what();
    }
}

}  // namespace
}  // namespace shaker::gpio
