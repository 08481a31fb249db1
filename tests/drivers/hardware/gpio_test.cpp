// The abort input on a line of a test: the contact, and its table of a rig file.
#include <gtest/gtest.h>

#include "drivers/errors.hpp"
#include "drivers/hardware/gpio/contact_input.hpp"

namespace shaker::gpio {
namespace {

using std::chrono::milliseconds;

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
    SettingsTable abort = table(at + "pull = 'down'");
    const AbortSettings a = read_abort(abort);
    abort.finish();
    EXPECT_EQ(a.at, (LineName{"gpiochip0", "17"}));
    EXPECT_TRUE(a.closed_high);
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
        open_input({"no_such_chip", "3"}, Pull::off);
        FAIL();
    } catch (const DeviceError& e) {
        EXPECT_NE(std::string{e.what()}.find("GPIO line 3 of no_such_chip: the chip cannot be opened"),
                  std::string::npos)
            << e.what();
    }
}

}  // namespace
}  // namespace shaker::gpio
