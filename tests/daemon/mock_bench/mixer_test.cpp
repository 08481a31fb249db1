// The controls of the sound card, which another program turns: amixer, of alsa-utils.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "drivers/recorded/recording_file.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::test {
namespace {

using namespace std::chrono_literals;

constexpr const char* run_options = "--gamma 0.5g --periods 20 -o run.nxs";

/// What amixer says or sets at the bench's card.
std::string amixer(const BenchRun& run, const std::string& words) {
    const std::string command = "ALSA_CONFIG_PATH='" + (run.folder / "asound.conf").string() +
                                "' amixer -D shaker_card " + words + " 2>&1";
    std::FILE* pipe = ::popen(command.c_str(), "r");
    std::string out;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) out += static_cast<char>(c);
    EXPECT_EQ(::pclose(pipe), 0) << command << ": " << out;
    return out;
}

TEST(MixerTest, ControlsAreKeptInTheRecordingAsAmixerPrintsThem) {
    BenchRun run;
    const std::string seen = amixer(run, "contents");
    EXPECT_NE(seen.find("iface=MIXER,name='Line 3/4 Playback Volume'"), std::string::npos) << seen;
    run.start(run_options);
    if (!in_real_time) return expect_order(run.finish());
    EXPECT_FALSE(run.results().empty());
    const std::string kept = recorded::RecordingReader{run.folder / "run.nxs"}.header().mixers;
    EXPECT_NE(kept.find("mixer of shaker_card\n"), std::string::npos) << kept;
    EXPECT_NE(kept.find("iface=MIXER,name='Line 3/4 Playback Volume' = 200,200\n"), std::string::npos)
        << kept;
    EXPECT_NE(kept.find("\n- iface=MIXER,name='Level Meter' = "), std::string::npos)
        << "it changes by itself";
}

TEST(MixerTest, AChangedVolumeIsRefusedAtRestAndSetBack) {
    BenchRun run;
    amixer(run, "cset name='Line 3/4 Playback Volume' 80,90");
    EXPECT_EQ(run.bench.mixer().volume(), 80);
    run.start(run_options);
    const Outcome refused = run.finish();
    EXPECT_EQ(refused.status, 2) << end_of(refused.err);
    EXPECT_NE(
        refused.err.find("the mixer of shaker_card has changed: iface=MIXER,name='Line 3/4 Playback Volume' "
                         "is 80,90 instead of 200,200"),
        std::string::npos)
        << end_of(refused.err);
    EXPECT_FALSE(std::filesystem::exists(run.folder / "run.nxs"));
    const Outcome check =
        shakerd("check --restore-mixer --rig '" + run.bench.rig_file().string() + "'", run.folder);
    EXPECT_EQ(run.bench.mixer().volume(), 200);
    EXPECT_NE(check.out.find("set back: mixer of shaker_card: iface=MIXER,name='Line 3/4 Playback Volume'"),
              std::string::npos)
        << check.out;
    run.start(run_options);
    if (!in_real_time) return expect_order(run.finish());
    EXPECT_EQ(run.finish().status, 0);
}

TEST(MixerTest, AVolumeThatIsTurnedStopsTheDrive) {
    BenchRun run;
    run.start("--gamma 0.5g --periods 2000");
    if (!in_real_time) return expect_order(run.finish());
    ASSERT_TRUE(run.played(6)) << end_of(run.finish().err);
    run.bench.mixer().set_volume(199);
    const Outcome o = run.finish();
    EXPECT_EQ(o.status, 5) << end_of(o.err);
    EXPECT_NE((o.out + o.err).find("controls of a sound card's mixer have changed"), std::string::npos)
        << end_of(o.err);
    EXPECT_NE(o.err.find("is 199,199 instead of 200,200"), std::string::npos) << end_of(o.err);
}

TEST(MixerTest, AVolumeThatIsTurnedEndsTheSelfTest) {
    BenchRun run;
    Program check{"shakerd", "check --rig '" + run.bench.rig_file().string() + "'", run.folder};
    while (!check.ended() && run.bench.dac().taken() < 2 * 48000) std::this_thread::sleep_for(10ms);
    run.bench.mixer().set_volume(199);
    const Outcome o = check.wait();
    EXPECT_NE(o.status, 0) << end_of(o.out);
    for (const char* words : {"BAD  mixer: the mixer of shaker_card has changed",
                              "is 199,199 instead of 200,200", "; the drive was stopped softly"})
        EXPECT_NE(o.out.find(words), std::string::npos) << words << ": " << end_of(o.out);
}

}  // namespace
}  // namespace shaker::test
