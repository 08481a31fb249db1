// Commissioning of an enable output and an abort input on the mock bench, with an operator who sees the tone
// and moves the contact.
#include <gtest/gtest.h>

#include <atomic>
#include <utility>

#include "daemon/commissioning/commission.hpp"
#include "drivers/commissioned/record.hpp"
#include "drivers/errors.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::commissioning {
namespace {

/// What the operator sees and moves; outlives the devices.
struct Desk {
    std::atomic<bool> on{false};  // the tone is played
    std::atomic<int> starts{0};   // of the tone
    std::atomic<bool> open{false};
};

class WatchedDac final : public Dac {
public:
    WatchedDac(std::unique_ptr<Dac> inner, Desk& desk) : inner_{std::move(inner)}, desk_{desk} {}
    [[nodiscard]] DacInfo info() const override { return inner_->info(); }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        return inner_->write(volts, trigger);
    }
    [[nodiscard]] std::int64_t take_back(std::int64_t most) noexcept override {
        return inner_->take_back(most);
    }
    void enable(bool on) noexcept override {
        if (on && !desk_.on.exchange(on)) ++desk_.starts;
        desk_.on = on;
        inner_->enable(on);
    }
    void stop() noexcept override { inner_->stop(); }

private:
    std::unique_ptr<Dac> inner_;
    Desk& desk_;
};

class FakeContact final : public AbortInput {
public:
    explicit FakeContact(Desk& desk) : desk_{desk} {}
    [[nodiscard]] Contact read(std::chrono::milliseconds wait) noexcept override {
        std::this_thread::sleep_for(std::min(wait, std::chrono::milliseconds{5}));
        return desk_.open ? Contact::open : Contact::closed;
    }

private:
    Desk& desk_;
};

struct SwitchesTest : testing::Test {
    test::BenchRun bench;
    Desk desk;
    bool keeps_open = true;  // until the program asks to close it
    std::string shown;
    std::vector<std::string> questions;
    std::vector<bool> tone;  // at each question

    void SetUp() override {
        if (!test::in_real_time) GTEST_SKIP() << "not in real time under a sanitiser";
        std::filesystem::remove(commissioned::record_of(bench.bench.rig_file()));
        bench.rig("second_channel", "\"trigger\"\nenable_channel = 3");
    }
    void obey(const std::string& text) {
        shown += text;
        if (text.find("Close the contact") != std::string::npos) desk.open = false;
        if (text.find("Open the contact") == std::string::npos) return;
        desk.open = true;
        if (keeps_open) return;
        std::this_thread::sleep_for(std::chrono::milliseconds{50});
        desk.open = false;
    }
    /// The day until the operator denies the question that has these words.
    bool commission_until(const std::string& denied) {
        const Settings settings{.rig = bench.bench.rig_file().string(),
                                .frequency_hz = test::nightly() ? 20.0 : 60.0,  // most waits count periods
                                .fit = [&](Rig& rig) {
                                    rig.dac = std::make_unique<WatchedDac>(std::move(rig.dac), desk);
                                    rig.abort_input = std::make_unique<FakeContact>(desk);
                                }};
        return commission(settings, {.show = [&](const std::string& text) { obey(text); },
                                     .ask =
                                         [&](const std::string& question) {
                                             questions.push_back(question);
                                             tone.push_back(desk.on);
                                             return question.find(denied) == std::string::npos ? "y" : "n";
                                         },
                                     .rethrow = [] {}});
    }
};

TEST_F(SwitchesTest, EnableIsConfirmedAndContactTimed) {
    EXPECT_FALSE(commission_until("true-RMS meter"));
    ASSERT_EQ(questions.size(), 4U) << shown;
    EXPECT_NE(questions[1].find("Is the amplifier switched off?"), std::string::npos) << questions[1];
    EXPECT_NE(questions[2].find("switch on before the base moved"), std::string::npos) << questions[2];
    EXPECT_EQ(tone, (std::vector<bool>{false, false, false, true}));
    EXPECT_EQ(desk.starts, 3) << "the drives of the enable output, of the abort input and of the gain";
    for (const char* words :
         {"ok   enable output, at rest: confirmed", "enable output, with the drive: confirmed",
          "ok   abort input: stopped ", " ms after the contact opened, ramp of ",
          "a clear was refused: the contact of the abort input is open"})
        EXPECT_NE(shown.find(words), std::string::npos) << words << "\n" << shown;
}

TEST_F(SwitchesTest, AmplifierThatStaysOnLeavesNoRecord) {
    EXPECT_FALSE(commission_until("Is the amplifier switched off?"));
    EXPECT_EQ(desk.starts, 0) << "nothing was driven";
    EXPECT_FALSE(std::filesystem::exists(commissioned::record_of(bench.bench.rig_file())));
}

TEST_F(SwitchesTest, ContactThatClosesTooEarlyIsNoTest) {
    keeps_open = false;
    try {
        commission_until("true-RMS meter");
        FAIL() << shown;
    } catch (const DeviceError& e) {
        EXPECT_NE(std::string{e.what()}.find("the contact closed before a clear was tried"),
                  std::string::npos)
            << e.what();
    }
}

}  // namespace
}  // namespace shaker::commissioning
