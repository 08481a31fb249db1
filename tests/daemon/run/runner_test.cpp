// Common behaviour of run, serve and check, which one runner leads.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "tests/support/program.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::run {
namespace {

using nlohmann::json;
using test::fresh_folder;
using test::Outcome;
using test::shakerd;

// The paper's bench with these cameras and changes.
std::filesystem::path bench(const std::string& changes = {}, const char* cameras = test::slow) {
    auto folder = fresh_folder();
    std::ofstream{folder / "scene.toml"} << cameras << changes;
    return folder;
}

std::vector<std::string> files_in(const std::filesystem::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
}

TEST(RunnerTest, RefusedRunLeavesNoFileAndMayBeCorrected) {
    const auto folder = bench("[shaker]\namplifier_gain = 1.0\n");
    const std::string options = "run --no-identify --scene scene.toml --periods 4 -o x.nxs --gamma ";
    const Outcome refused = shakerd(options + "2g", folder);
    EXPECT_EQ(refused.status, 2) << refused.err;
    for (const std::string& name : files_in(folder))
        EXPECT_FALSE(name.starts_with("x.")) << name << " was left";
    const Outcome corrected = shakerd(options + "0.3g", folder);
    EXPECT_EQ(corrected.status, 0) << corrected.err;
    EXPECT_TRUE(std::filesystem::exists(folder / "x.nxs"));
}

// The walker reaches the edge of the picture after some 24 of 40 periods.
TEST(RunnerTest, TrippedRunPrintsThePeriodsMeasuredBefore) {
    const auto folder = bench();
    const std::string options = "run --scene scene.toml --gamma 1.5g --phi 35deg --periods 40 ";
    const Outcome o = shakerd(options + "--json", folder);
    EXPECT_EQ(o.status, 5) << o.err;
    const json r = json::parse(o.out, nullptr, false);
    ASSERT_FALSE(r.is_discarded()) << o.out;
    EXPECT_EQ(r["trips"][0]["cause"], "walker_edge");
    const double periods = 20 * (r["to_s"].get<double>() - r["from_s"].get<double>());
    EXPECT_GT(periods, 15);
    EXPECT_LT(periods, 40);
    const double v = r["v_D_mps"], truth = r["v_D_true_mps"];
    EXPECT_LT(std::abs(v - truth), 0.01 * std::abs(truth));
    EXPECT_NE(r["notes"].dump().find("a limit stopped the run"), std::string::npos) << r["notes"];
    const Outcome text = shakerd(options, folder);
    EXPECT_EQ(text.status, 5);
    EXPECT_NE(text.out.find("a limit stopped this run at "), std::string::npos) << text.out;
    EXPECT_NE(text.out.find("v_D"), std::string::npos) << text.out;
}

TEST(RunnerTest, TripBeforeMeasurementIsReported) {
    const auto folder = bench("[[fault]]\nat_s = 1\nwhat = \"saturated\"\n");
    const Outcome o = shakerd("run --scene scene.toml --json", folder);
    EXPECT_EQ(o.status, 5) << o.err;
    const json r = json::parse(o.out, nullptr, false);
    ASSERT_FALSE(r.is_discarded()) << o.out;
    EXPECT_EQ(r["trips"].size(), 1U);
    EXPECT_NE(r["not_reduced"].get<std::string>().find("fewer than two periods"), std::string::npos);
}

TEST(RunnerTest, KnownMuGivesPeriodsUntilTheEdgeFirst) {
    const auto folder = bench();
    const std::string options = "run --scene scene.toml --periods 4 --json ",
                      words = "periods until the edge limit";
    const Outcome told = shakerd(options + "--mu 0.113", folder);
    ASSERT_EQ(told.status, 0) << told.err;
    const auto at = told.err.find(words);
    ASSERT_NE(at, std::string::npos) << told.err;
    EXPECT_LT(at, told.err.find("identification: measuring")) << "before anything moves";
    EXPECT_NE(told.err.find("predicted walk +14.6"), std::string::npos) << told.err;
    EXPECT_NE(json::parse(told.out)["notes"].dump().find(words), std::string::npos) << told.out;
    EXPECT_EQ(shakerd(options, folder).err.find(words), std::string::npos) << "mu is not known";
}

TEST(RunnerTest, MeasurementBeyondMemoryIsRefused) {
    const auto folder = bench();
    const Outcome o = shakerd(
        "run --scene scene.toml --frequency 2Hz --gamma 0.05m/s^2 --periods 1000000 -o x.nxs", folder);
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(o.err.find("of memory"), std::string::npos) << o.err;
    for (const std::string& name : files_in(folder))
        EXPECT_FALSE(name.starts_with("x.")) << name << " was left";
}

// The gain of the amplifier rises by a factor of 50 in the middle of the self-test.
TEST(RunnerTest, CheckStopsFaultyShaker) {
    const auto folder = bench(
        "[limits]\nacceleration_warn_mps2 = 8\nacceleration_abort_mps2 = 10\n"
        "[[fault]]\nwhat = \"amplifier_gain\"\nvalue = 50\nat_s = 2\n");
    const Outcome o = shakerd("check --json --scene scene.toml", folder);
    EXPECT_EQ(o.status, 3) << o.err;
    const json r = json::parse(o.out);
    EXPECT_FALSE(r["sound"]);
    EXPECT_NE(r["findings"].dump().find("the drive was stopped: peak acceleration of the base"),
              std::string::npos)
        << o.out;
}

TEST(RunnerTest, CheckOfASoundBenchPasses) {
    const Outcome o = shakerd("check --scene scene.toml", bench("", test::rendered));
    EXPECT_EQ(o.status, 0) << o.out << o.err;
    EXPECT_NE(o.out.find("the bench is fit to run"), std::string::npos) << o.out;
}

// Half of the gravity of the place: the gain of the sensor is not what the rig file says.
TEST(RunnerTest, CheckOfAWrongGainFails) {
    const Outcome o =
        shakerd("check --scene scene.toml", bench("[[fault]]\nwhat = \"gain\"\nvalue = 0.5\nat_s = 0\n"));
    EXPECT_EQ(o.status, 3) << o.out << o.err;
    EXPECT_NE(o.out.find("gravity is -50"), std::string::npos) << o.out;
    EXPECT_NE(o.out.find("the bench is not fit to run"), std::string::npos) << o.out;
}

constexpr const char* early_warning = "[limits]\nacceleration_warn_mps2 = 2\n";

TEST(RunnerTest, ServeReportsWarningsAsEventsAndNotes) {
    const auto folder = fresh_folder();
    test::Answers answers;
    RunOptions quick;
    quick.pictures = recorded::KeptPictures::off;
    const auto measured = [](const service::BenchState& s) { return s.result != nullptr; };
    const auto r = test::play_on_call(std::string{test::slow} + early_warning, quick, folder,
                                      {{test::in(RunState::idle), test::orders(service::Begin{10}, answers)},
                                       {measured, test::orders(service::End{}, answers)},
                                       {test::in(RunState::idle), [](service::BenchPort&) {}}});
    const auto about = [](const std::string& text) {
        return text.find("warnings: acceleration") != std::string::npos;
    };
    EXPECT_EQ(
        std::ranges::count_if(
            r.events, [&](const service::BenchEvent& e) { return e.kind == "warning" && about(e.text); }),
        1);
    ASSERT_TRUE(r.last.result);
    EXPECT_EQ(std::ranges::count_if(r.last.result->notes, about), 1);
}

TEST(RunnerTest, SimulatedRunIsMarkedAsVirtualTime) {
    const auto folder = bench();
    const Outcome o =
        shakerd("run --no-identify --scene scene.toml --periods 4 --gamma 0.3g -o x.nxs", folder);
    ASSERT_EQ(o.status, 0) << o.err;
    const h5::Handle file = h5::open_file(folder / "x.nxs");
    EXPECT_TRUE(h5::read_attribute_text(file.get(), "entry", "time_reference").starts_with("virtual time"));
}

TEST(RunnerTest, EndTimeExcludesIdleTimeOfDaemon) {
    const auto folder = fresh_folder();
    test::Answers answers;
    RunOptions quick;
    quick.pictures = recorded::KeptPictures::off;
    static_cast<void>(test::play_on_call(
        test::slow, quick, folder,
        {{[](const service::BenchState& s) { return s.now_s > 20; },
          test::orders(service::Record{true, "late", recorded::KeptPictures::off}, answers)},
         {test::in(RunState::idle), test::orders(service::Begin{3}, answers)},
         {test::in(RunState::run), test::orders(service::End{}, answers)},
         {test::in(RunState::idle), [](service::BenchPort&) {}}},
        120));
    ASSERT_EQ(answers, test::Answers(3, ""));
    const recorded::RecordingReader file{folder / "late.nxs"};
    EXPECT_EQ(file.text("start_time"), "1970-01-01T00:00:00+00:00");
    const std::string end = file.text("end_time");
    EXPECT_LT(end, "1970-01-01T00:00:18") << "of a recording that began 20 s after the daemon";
}

/// Makes impossible transitions, as an error in the program could.
class DerailedSequence : public Sequence {
public:
    using Sequence::go;
    using Sequence::Sequence;
};

TEST(SequenceTest, ImpossibleTransitionStopsTheDrive) {
    AccelerometerInfo accelerometer;
    accelerometer.rate_hz = 4000;
    DerailedSequence sequence{{}, 48000, accelerometer, [](const std::string&) {}};
    acquisition::Channels channels{0};
    ASSERT_EQ(sequence.state(), RunState::init);
    sequence.go(run::Run{}, channels);
    EXPECT_EQ(sequence.state(), RunState::init);
    EXPECT_TRUE(channels.ordered.pop()) << "the output is to stop";
    ASSERT_EQ(sequence.notes().size(), 1U);
    EXPECT_NE(sequence.notes()[0].find("cannot go from state init to run"), std::string::npos);
}

TEST(RunnerTest, CheckJudgesMissingPictures) {
    const auto checked = [](const char* for_s) {
        return shakerd("check --scene scene.toml",
                       bench("[[fault]]\nwhat = \"camera_stall\"\ncamera = \"side\"\nat_s = 2\nfor_s = " +
                             std::string{for_s} + "\n"));
    };
    const Outcome few = checked("0.2"), many = checked("3");
    EXPECT_EQ(few.status, 0) << few.out;
    EXPECT_NE(few.out.find("% of the pictures are missing"), std::string::npos) << few.out;
    EXPECT_NE(many.status, 0) << many.out;
    EXPECT_NE(many.out.find("not fit above 20 %"), std::string::npos) << many.out;
    const Outcome none = shakerd("check --scene scene.toml", bench());
    EXPECT_EQ(none.out.find("pictures are missing"), std::string::npos) << none.out;
}

}  // namespace
}  // namespace shaker::run
