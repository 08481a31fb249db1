// A sound card with an analog sensor that was set or wired wrongly: "shakerd check" names the cause, by real
// libasound and Aravis.
#include <gtest/gtest.h>

#include <array>
#include <utility>
#include <vector>

#include "tests/support/in_real_time.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::test {
namespace {

struct Mistake {
    const char* name;
    std::pair<const char*, const char*> key;  // of the rig file, and its wrong value
    const char* scene;                        // of the mock, beside the sensor's keys
    std::vector<const char*> said;
};

const std::array mistakes{
    Mistake{"right", {}, "", {"the bench is fit to run"}},
    Mistake{"no_such_input", {"channels", "[9]"}, "", {"channel 9 is not possible", "it has are 2, 8"}},
    Mistake{"another_input",
            {"channels", "[2]"},
            "",
            {"an axis is constant", "its supply or conditioner, and its channel"}},
    Mistake{"no_such_card",
            {"pcm", "\"hw:CARD=M4,DEV=0\""},
            "",
            {"hw:CARD=M4,DEV=0", "\"shakerd devices\" lists the sound cards"}},
    Mistake{"drive_and_trigger_swapped",
            {"second_channel", "\"trigger\"\ndrive_channel = 2\ntrigger_channel = 1"},
            "",
            {"does the trigger line reach it", "whether drive_channel and trigger_channel are swapped"}},
    Mistake{"sensor_on_another_card", {"clock", "\"dac\""}, "clock_ppm = -100\n", {"it is another card"}}};

struct WrongCardTest : testing::TestWithParam<Mistake> {};

TEST_P(WrongCardTest, CheckNamesTheCause) {
    const Mistake& m = GetParam();
    std::string sensor = "[accelerometer]\naxes = 1\ngravity = 0\nyaw_deg = 0\nrate_hz = 48000\nbits = 24\n",
                other = m.scene;
    if (!other.starts_with("clock_ppm")) sensor += "clock_ppm = 0\n";
    BenchRun run{0, sensor + other, true};
    if (m.key.first != nullptr) run.rig(m.key.first, m.key.second);
    const Outcome o = shakerd("check --rig '" + run.bench.rig_file().string() + "'", run.folder);
    if (!in_real_time) return expect_order(o);
    EXPECT_EQ(o.status == 0, std::string{m.name} == "right");
    for (const Mistake& any : mistakes)
        for (const char* words : any.said)
            EXPECT_EQ((o.out + o.err).find(words) != std::string::npos, any.name == m.name) << words << "\n"
                                                                                            << o.out << o.err;
}

INSTANTIATE_TEST_SUITE_P(All, WrongCardTest, testing::ValuesIn(mistakes),
                         [](const auto& from) { return std::string{from.param.name}; });

}  // namespace
}  // namespace shaker::test
