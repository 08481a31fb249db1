// A complete run on the mock bench: results of the program compared with the truth of the bench.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "drivers/hardware/alsa/output_frames.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "drivers/synthesiser.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::test {
namespace {

constexpr double rate_hz = 48000;
constexpr int block = 480;

/// Both channels of the mock DAC's output, left-justified.
struct Codes {
    std::vector<std::int32_t> drive, trigger;
};
Codes codes_of(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    Codes codes;
    std::int32_t pair[2];
    while (in.read(reinterpret_cast<char*>(pair), sizeof pair)) {
        codes.drive.push_back(pair[0]);
        codes.trigger.push_back(pair[1]);
    }
    return codes;
}

/// Every sample of the drive up to the stop, computed from the recorded changes.
std::vector<std::int32_t> played_again(const recorded::RecordingReader& recording) {
    const std::vector<DriveChange> changes = recording.changes();
    Synthesiser synthesiser{rate_hz, recording.header().frequency_hz, 1};
    const alsa::PcmCodec codec{alsa::SampleFormat::s32, 32, 1};
    std::vector<std::int32_t> codes;
    std::vector<double> volts(block);
    std::size_t next = 0;
    const std::int64_t end = changes.back().first.n + changes.back().ramp;
    for (std::int64_t tick = 0; tick < end; tick += block) {
        if (next < changes.size() && changes[next].first.n < tick + block) {
            if (changes[next].stop == 0) synthesiser.set(changes[next].command);
            ++next;
        }
        synthesiser.fill(volts);
        for (int i = 0; i < block; ++i) {
            std::int32_t code = 0;
            codec.put(reinterpret_cast<std::byte*>(&code),
                      codec.dithered(volts[static_cast<std::size_t>(i)], {tick + i}, 0));
            codes.push_back(code);
        }
    }
    codes.resize(static_cast<std::size_t>(end));
    return codes;
}

TEST(ClosedRunTest, LeadOfTheEnableOutputIsNoSilenceOfTheSensor) {
    BenchRun run;
    run.rig("second_channel", "\"trigger\"\nenable_channel = 3\nenable_before_s = 5");
    run.start("--no-identify --gamma 0.5g --periods 4 --settle 4");
    if (!in_real_time) return expect_order(run.finish());
    const Outcome o = run.finish();
    EXPECT_EQ(o.status, 0) << end_of(o.err);
}

TEST(ClosedRunTest, GivesTrueDriftClockErrorAndExactWaveform) {
    BenchRun run{37.5};
    run.start("--gamma 1g --phi 100deg --periods 40 -o run.nxs");
    if (!in_real_time) return expect_order(run.finish());
    const nlohmann::json r = run.results();
    ASSERT_FALSE(r.empty());

    const double v_true = run.bench.drift(1, r.at("from_s"), r.at("to_s"), r.at("frequency_hz"));
    const double v_D = r.at("v_D_mps");
    EXPECT_NEAR(v_D / v_true, 1, 0.01);
    EXPECT_NEAR(v_D, v_true, 8 * r.at("v_D_se_mps").get<double>() + 1e-4 * v_true);
    EXPECT_NEAR(r.at("dac_ppm"), 37.5, 1);
    EXPECT_NEAR(r.at("gamma_mps2"), 9.8, 0.01);  // 1e-3: tolerance of the settled control
    EXPECT_NEAR(r.at("phi_rad"), 100 * std::numbers::pi / 180, 1e-3);

    for (const char* camera : {"top", "side"}) EXPECT_EQ(device(r, camera).at("lost"), 0) << camera;
    EXPECT_EQ(device(r, "adxl355").at("lost"), 0);
    EXPECT_EQ(device(r, "shaker_mock").at("lost"), 0);
    EXPECT_EQ(run.bench.dac().counts().underruns, 0U);

    const std::vector<std::int32_t> expected =
        played_again(recorded::RecordingReader{run.folder / "run.nxs"});
    ASSERT_GT(expected.size(), 4 * 48000U);
    const Codes put_out = codes_of(run.folder / "codes");
    const auto tick0 =
        std::ranges::find_if(put_out.trigger, [](std::int32_t c) { return c > 0; }) - put_out.trigger.begin();
    ASSERT_GT(static_cast<std::size_t>(put_out.drive.end() - put_out.drive.begin() - tick0), expected.size());
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < expected.size(); ++i)
        wrong += put_out.drive[static_cast<std::size_t>(tick0) + i] != expected[i] ? 1 : 0;
    EXPECT_EQ(wrong, 0U) << "of " << expected.size() << " samples";

    const Outcome again = shakerd("replay run.nxs", run.folder);
    EXPECT_EQ(again.status, 0) << again.out << again.err;
}

TEST(ClosedRunTest, CheckPassesAndReportsEveryClock) {
    BenchRun run{-80};
    const Outcome o = shakerd("check --json --rig '" + run.bench.rig_file().string() + "'", run.folder);
    if (!in_real_time) return expect_order(o);
    ASSERT_EQ(o.status, 0) << o.out << end_of(o.err);
    const auto j = nlohmann::json::parse(o.out);
    EXPECT_TRUE(j.at("sound"));
    const auto says = [&](const std::string& device, const std::string& words) {
        for (const auto& f : j.at("findings"))
            if (f.at("device").get<std::string>().find(device) != std::string::npos &&
                f.at("text").get<std::string>().find(words) != std::string::npos)
                return true;
        return false;
    };
    double ppm = 0;
    for (const auto& f : j.at("findings"))
        if (const std::string text = f.at("text");
            f.at("device") == "shaker_mock" && text.find(" ppm fast") != std::string::npos)
            ppm = std::stod(text.substr(text.find("Hz, ") + 4));
    EXPECT_NEAR(ppm, -80, 1);
    EXPECT_TRUE(says("cameras", "polarity is right")) << o.out;
    EXPECT_TRUE(says("adxl355", "polarity is right")) << o.out;
    EXPECT_TRUE(says("camera \"top\"", "\"walker\" found in")) << o.out;
}

TEST(ClosedRunTest, CheckDetectsSwappedWires) {
    BenchRun run{0, "[shaker]\namplifier_gain = -10\n"};
    // The rig file is right about everything but the polarity.
    run.rig("amplifier_gain", "10");
    const Outcome o = shakerd("check --rig '" + run.bench.rig_file().string() + "'", run.folder);
    if (!in_real_time) return expect_order(o);
    EXPECT_EQ(o.status, 3);
    EXPECT_NE(o.out.find("polarity is inverted: swap the wires"), std::string::npos)
        << o.out << end_of(o.err);
    EXPECT_NE(o.out.find("the bench is not fit to run"), std::string::npos) << o.out;
}

}  // namespace
}  // namespace shaker::test
