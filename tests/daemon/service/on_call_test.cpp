#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "daemon/commands/replay.hpp"
#include "daemon/recording/journal.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/pictures/picture_check.hpp"
#include "tests/support/program.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using test::Answers;
using test::in;
using test::orders;
using test::play_on_call;
using test::quick;
using test::rendered;
using test::slow;

// The bench waits for orders, also after a stop.
auto measured(std::size_t n) {
    return [n](const BenchState& s) { return s.points.size() >= n; };
}

TEST(OnCallTest, MeasuresRepeatedlyFromIdleToIdle) {
    const auto folder = test::fresh_folder();
    Answers answers;
    const auto r = play_on_call(slow, quick(), folder,
                                {{in(run::RunState::idle), orders(Begin{10}, answers)},
                                 {measured(3), orders(End{}, answers)},
                                 {in(run::RunState::idle), [](BenchPort&) {}}});
    EXPECT_EQ(answers, (Answers{"", ""}));
    const auto& parts = r.last.parts;
    ASSERT_GE(parts.size(), 3U);
    ASSERT_EQ(parts.size(), r.last.points.size());
    for (std::size_t i = 1; i < parts.size(); ++i)
        EXPECT_EQ(parts[i].from_s, parts[i - 1].to_s) << "one measurement follows the other without a gap";
    EXPECT_EQ(r.last.state, run::RunState::idle);
    EXPECT_FALSE(r.last.trip);
}

TEST(OnCallTest, SecondRunKeepsResponseAndMeasuresNewSetPoint) {
    const auto folder = test::fresh_folder();
    Answers answers;
    Drive other;
    other.gamma = 7;
    other.frequency = 25;
    const auto r = play_on_call(slow, quick(), folder,
                                {{in(run::RunState::idle), orders(Begin{10}, answers)},
                                 {measured(1), orders(End{}, answers)},
                                 {in(run::RunState::idle), orders(SetDrive{other}, answers)},
                                 {in(run::RunState::idle), orders(Begin{10}, answers)},
                                 {measured(2), orders(End{}, answers)},
                                 {in(run::RunState::idle), [](BenchPort&) {}}});
    EXPECT_EQ(answers, Answers(5, ""));
    EXPECT_EQ(std::ranges::count(r.events, std::string{"identify"}, &BenchEvent::text), 1);
    const reduction::DrivenPoint& last = r.last.points.at(1);
    EXPECT_NEAR(last.gamma.value, 7, 0.01);
    EXPECT_EQ(last.asked.frequency, 25);
}

TEST(OnCallTest, KnownMuGivesClosedFormForPoints) {
    Answers answers;
    const auto r = play_on_call(slow, quick(), test::fresh_folder(),
                                {{in(run::RunState::idle), orders(Begin{20}, answers)},
                                 {measured(1), orders(End{}, answers)},
                                 {in(run::RunState::idle), [](BenchPort&) {}}},
                                60, {0.113, 0});
    ASSERT_EQ(r.last.closed_form.size(), r.last.points.size());
    // The walker never sticks. Its reaction on the base, 0.1 to 0.2 % of gamma in each odd harmonic from the
    // 9th on, is not corrected by the two requested harmonics and changes v_D by 0.36 %.
    EXPECT_NEAR(r.last.closed_form[0] / r.last.points[0].v_D.value, 1, 5e-3);
    EXPECT_EQ(r.last.mu.value, 0.113);
}

TEST(OnCallTest, MeasuresAfterRequestedSettlePeriods) {
    double since_s[2] = {};
    for (const int settle : {1, 40}) {
        Answers answers;
        const auto r = play_on_call(slow, quick(), test::fresh_folder(),
                                    {{in(run::RunState::idle), orders(Begin{10, settle}, answers)},
                                     {measured(1), orders(End{}, answers)},
                                     {in(run::RunState::idle), [](BenchPort&) {}}});
        const auto run = std::ranges::find(r.events, std::string{"run"}, &BenchEvent::text);
        ASSERT_NE(run, r.events.end());
        since_s[settle == 40 ? 1 : 0] = r.last.parts.at(0).from_s - run->t_s;
    }
    EXPECT_NEAR(since_s[1] - since_s[0], 39 / 20.0, 2 / 20.0);
}

TEST(OnCallTest, OpenLoopDoesNotCorrectDrive) {
    Answers answers;
    const auto r = play_on_call(slow, quick(), test::fresh_folder(),
                                {{in(run::RunState::idle), orders(CloseLoop{false}, answers)},
                                 {in(run::RunState::idle), orders(Begin{10}, answers)},
                                 {measured(1), orders(CloseLoop{true}, answers)},
                                 {measured(1), orders(End{}, answers)},
                                 {in(run::RunState::idle), [](BenchPort&) {}}});
    ASSERT_EQ(answers.size(), 4U);
    EXPECT_NE(answers[2].find("while the bench is running"), std::string::npos) << answers[2];
    EXPECT_FALSE(r.last.closed_loop);
    EXPECT_GT(std::abs(r.last.points.at(0).gamma.value / paper_g - 1), 2e-3) << "nothing corrected it";
    EXPECT_EQ(std::ranges::count(r.events, std::string{"identify"}, &BenchEvent::text), 0);
}

TEST(OnCallTest, OvertonesAreDrivenAsRequested) {
    Answers answers;
    Drive drive;
    drive.gamma = 7;
    drive.overtones[0] = std::polar(0.3, 1.0);
    drive.overtones[3] = std::polar(0.1, -2.0);
    const auto r = play_on_call(slow, quick(), test::fresh_folder(),
                                {{in(run::RunState::idle), orders(SetDrive{drive}, answers)},
                                 {in(run::RunState::idle), orders(Begin{10}, answers)},
                                 {measured(1), orders(End{}, answers)},
                                 {in(run::RunState::idle), [](BenchPort&) {}}});
    EXPECT_EQ(answers, Answers(3, ""));
    ASSERT_TRUE(r.last.result);
    const auto& harmonics = r.last.result->harmonics;
    for (const auto& [q, amplitude] : {std::pair{3, 2.1}, {6, 0.7}}) {
        const auto found = std::ranges::find(harmonics, q, &reduction::MeasuredHarmonic::q);
        ASSERT_NE(found, harmonics.end()) << q;
        EXPECT_NEAR(found->amplitude.value, amplitude, 0.007) << q;
    }
}

// The walker has moved since the daemon learned its targets.
TEST(OnCallTest, RecordingAfterWalkerMovedReplaysFromPictures) {
    for (const recorded::KeptPictures pictures :
         {recorded::KeptPictures::region, recorded::KeptPictures::full}) {
        const auto folder = test::fresh_folder();
        run::RunOptions run = quick();
        run.pictures = pictures;
        run.drive.phi = 1.75;  // a slow walk
        Answers answers;
        const auto r =
            play_on_call(rendered, run, folder,
                         {{in(run::RunState::idle), orders(Begin{20}, answers)},
                          {measured(2), orders(End{}, answers)},
                          {in(run::RunState::idle), orders(Record{true, "second", pictures}, answers)},
                          {in(run::RunState::idle), orders(Begin{10}, answers)},
                          {measured(3), orders(End{}, answers)},
                          {in(run::RunState::idle), [](BenchPort&) {}}});
        EXPECT_EQ(answers, Answers(5, ""));
        const commands::ReplayOptions raw{.file = folder / "second.nxs",
                                          .from = commands::ReplayOptions::From::raw};
        EXPECT_TRUE(replay(raw)) << name(pictures);
        const auto notes = std::ranges::count_if(r.events, [](const BenchEvent& e) {
            return e.kind == "note" && !e.text.starts_with("predicted walk");
        });
        EXPECT_EQ(notes, 1) << "its file only";
    }
}

TEST(OnCallTest, DefaultRecordingKeepsPicturesOfFirstSecond) {
    const auto folder = test::fresh_folder();
    run::RunOptions run = quick();
    run.pictures = run::RunOptions{}.pictures;
    Answers answers;
    play_on_call(rendered, run, folder,
                 {{in(run::RunState::idle), orders(Record{true, "night", run.pictures}, answers)},
                  {in(run::RunState::idle), orders(Begin{10}, answers)},
                  {measured(2), orders(End{}, answers)},
                  {in(run::RunState::idle), [](BenchPort&) {}}});
    EXPECT_EQ(answers, Answers(3, ""));
    const recorded::RecordingReader file{folder / "night.nxs"};
    EXPECT_EQ(file.header().pictures, recorded::KeptPictures::first_second);
    for (const View& view : file.header().views) {
        const std::string counts = "pictures/" + view.camera + "/";
        EXPECT_EQ(file.scalar(counts + "stored"), view.frame_rate_hz) << view.camera;
        EXPECT_EQ(file.scalar(counts + "dropped"), 0) << view.camera;
        EXPECT_GT(file.scalar(counts + "not_kept"), view.frame_rate_hz) << view.camera;
        EXPECT_TRUE(pictures::verify_frames(folder / "night.frames", view.camera).bad.empty());
    }
    EXPECT_TRUE(commands::replay({.file = file.file()})) << "by its tracks";
    try {
        commands::replay({.file = file.file(), .from = commands::ReplayOptions::From::raw});
        FAIL() << "tracked pictures that are not there";
    } catch (const InputError& e) {
        EXPECT_NE(std::string{e.what()}.find("only the pictures of the first second were kept"),
                  std::string::npos)
            << e.what();
    }
}

TEST(OnCallTest, RecordingWithPicturesNeedsAllTargets) {
    run::RunOptions run = quick();
    run.pictures = recorded::KeptPictures::full;
    Answers answers;
    const auto hidden = [](const BenchState& s) {
        return s.state == run::RunState::idle && s.walker && s.walker->lost > 2;
    };
    play_on_call(
        std::string{rendered} + "[[fault]]\nwhat = \"walker_hidden\"\nat_s = 1\n", run, test::fresh_folder(),
        {{in(run::RunState::idle), orders(Record{true, "blind", recorded::KeptPictures::full}, answers)},
         {hidden, orders(Begin{10}, answers)}});
    ASSERT_EQ(answers.size(), 2U);
    EXPECT_NE(answers[1].find("target \"walker\": not visible"), std::string::npos) << answers[1];
}

TEST(OnCallTest, RemarksGoToOpenOrNextRecording) {
    const auto folder = test::fresh_folder();
    Answers answers;
    play_on_call(
        slow, quick(), folder,
        {{in(run::RunState::idle), orders(Remark{"new paper"}, answers)},
         {in(run::RunState::idle), orders(Remark{std::string(401, 'x')}, answers)},
         {in(run::RunState::idle), orders(Remark{"a\nb"}, answers)},
         {in(run::RunState::idle), orders(Remark{"\xff"}, answers)},
         {in(run::RunState::idle), orders(Record{true, "remarks", recorded::KeptPictures::off}, answers)},
         {in(run::RunState::idle), orders(Begin{10}, answers)},
         {in(run::RunState::run), orders(Remark{"the lamp flickers"}, answers)},
         {measured(1), orders(End{}, answers)},
         {in(run::RunState::idle), [](BenchPort&) {}}});
    ASSERT_EQ(answers.size(), 8U);
    for (const std::size_t i : {1U, 2U, 3U})
        EXPECT_NE(answers[i].find("1 to 400"), std::string::npos) << answers[i];
    std::vector<std::string> texts;
    for (const recording::LogEntry& entry :
         recording::read_log(recorded::RecordingReader{folder / "remarks.nxs"}))
        if (entry.text.starts_with("remark: ")) texts.push_back(entry.text + " (" + entry.state + ")");
    EXPECT_EQ(texts,
              (std::vector<std::string>{"remark: new paper (idle)", "remark: the lamp flickers (run)"}));
}

TEST(OnCallTest, RefusedOrderHasReasonAndChangesNothing) {
    const auto folder = test::fresh_folder();
    Answers answers;
    Drive wild;
    wild.gamma = 500;
    const LowerLimit raised{{&safety::Limits::acceleration}, 1e6};
    const auto r = play_on_call(
        slow, quick(), folder,
        {{in(run::RunState::idle), orders(SetDrive{wild}, answers)},
         {in(run::RunState::idle), orders(Begin{1}, answers)},
         {in(run::RunState::idle), orders(End{}, answers)},
         {in(run::RunState::idle), orders(ClearTrip{}, answers)},
         {in(run::RunState::idle), orders(raised, answers)},
         {in(run::RunState::idle), orders(Record{true, "../x", recorded::KeptPictures::off}, answers)}});
    ASSERT_EQ(answers.size(), 6U);
    const std::vector<std::string> words{
        "acceleration",       "periods 1", "there is no drive to stop", "there is no trip to clear",
        "limit acceleration", "\"../x\""};
    for (std::size_t i = 0; i < words.size(); ++i)
        EXPECT_NE(answers[i].find(words[i]), std::string::npos) << answers[i];
    EXPECT_EQ(r.last.wanted.gamma, paper_g);
}

TEST(OnCallTest, TakenRecordingNameIsRefusedAtTheOrder) {
    const auto folder = test::fresh_folder();
    std::ofstream{folder / "first.nxs"};
    std::ofstream{folder / "second.nxs.part"};
    constexpr auto off = recorded::KeptPictures::off;
    Answers answers;
    const auto r = play_on_call(slow, quick(), folder,
                                {{in(run::RunState::idle), orders(Record{true, "first", off}, answers)},
                                 {in(run::RunState::idle), orders(Record{true, "second", off}, answers)}});
    ASSERT_EQ(answers.size(), 2U);
    EXPECT_NE(answers[0].find((folder / "first.nxs").string() + ": exists already"), std::string::npos)
        << answers[0];
    EXPECT_NE(answers[1].find("second.nxs.part"), std::string::npos) << answers[1];
    EXPECT_FALSE(r.last.record);
}

TEST(OnCallTest, StateHasNameOfNextRecording) {
    constexpr auto off = recorded::KeptPictures::off;
    for (const auto& [order, name] : {std::pair{Record{true, "walk", off}, "walk"},
                                      {Record{true, "walk.nxs", off}, "walk"},
                                      {Record{true, "", off}, ""}}) {
        Answers answers;
        const auto r = play_on_call(slow, quick(), test::fresh_folder(),
                                    {{in(run::RunState::idle), orders(order, answers)}});
        EXPECT_EQ(answers, Answers{""});
        EXPECT_TRUE(r.last.record);
        EXPECT_EQ(r.last.record_name, name);
    }
}

TEST(OnCallTest, ResultsCarryNumberTimeAndSetPoint) {
    Drive turned;
    turned.phi = 1;
    std::vector<BenchState> seen;
    const auto look = [&](BenchPort& port) { seen.push_back(*port.state()); };
    Answers answers;
    play_on_call(slow, quick(), test::fresh_folder(),
                 {{in(run::RunState::idle), orders(Begin{10}, answers)},
                  {measured(1), look},
                  {measured(1), orders(SetDrive{turned}, answers)},
                  {[](const BenchState& s) { return s.wanted.phi == 1; }, look},
                  {measured(2), look},
                  {measured(2), orders(End{}, answers)},
                  {in(run::RunState::idle), [](BenchPort&) {}}});
    ASSERT_EQ(seen.size(), 3U);
    for (const BenchState& s : seen) {
        EXPECT_EQ(s.result_origin.number, s.points.size());
        EXPECT_EQ(s.result_origin.from_s, s.parts.back().from_s);
        EXPECT_EQ(s.result_origin.to_s, s.parts.back().to_s);
    }
    EXPECT_TRUE(same(seen[0].result_origin.asked, seen[0].wanted));
    EXPECT_FALSE(same(seen[1].result_origin.asked, seen[1].wanted)) << "the result is of phi 0 still";
    EXPECT_EQ(seen[2].result_origin.asked.phi, 1);
}

TEST(OnCallTest, WalkerIsBetweenEndsOfPicture) {
    const auto ends = [](const char* scene) {
        const auto r = play_on_call(
            scene, quick(), test::fresh_folder(),
            {{[](const BenchState& s) { return s.walker && s.now_s > 0.5; }, [](BenchPort&) {}}});
        return r.last.walker.value();
    };
    const WalkerState walker = ends(rendered);
    EXPECT_NEAR(walker.left_m, 0, 1e-12);
    EXPECT_GT(walker.x_m, walker.left_m);
    EXPECT_LT(walker.x_m, walker.right_m);
    const double nearer_m = std::min(walker.x_m - walker.left_m, walker.right_m - walker.x_m);
    EXPECT_NEAR(nearer_m, walker.edge_m + 0.015, 0.002) << "radius 15 mm, seen 2 % larger or smaller";
}

TEST(OnCallTest, RecordedRunHasItsNameAndReplays) {
    const auto folder = test::fresh_folder();
    Answers answers;
    const auto r = play_on_call(
        slow, quick(), folder,
        {{in(run::RunState::idle), orders(Record{true, "first", recorded::KeptPictures::off}, answers)},
         {in(run::RunState::idle), orders(Begin{10}, answers)},
         {measured(2), orders(End{}, answers)},
         {in(run::RunState::idle), [](BenchPort&) {}}});
    EXPECT_EQ(answers, Answers(3, ""));
    ASSERT_TRUE(std::filesystem::exists(folder / "first.nxs"));
    EXPECT_TRUE(commands::replay({.file = folder / "first.nxs"}));
}

TEST(OnCallTest, RefusedIdentifyLeavesTheRecordingAlone) {
    const auto end_time = [](bool identify) {
        const auto folder = test::fresh_folder();
        Answers answers;
        std::vector<test::Move> moves{
            {in(run::RunState::idle), orders(Record{true, "first", recorded::KeptPictures::off}, answers)},
            {in(run::RunState::idle), orders(Begin{10}, answers)}};
        if (identify) moves.push_back({measured(1), orders(Identify{}, answers)});
        moves.push_back({measured(2), orders(End{}, answers)});
        moves.push_back({in(run::RunState::idle), [](BenchPort&) {}});
        play_on_call(slow, quick(), folder, moves);
        if (identify) {
            EXPECT_NE(answers.at(2).find(
                          "identification cannot start while the bench is running; stop the drive first"),
                      std::string::npos);
        }
        const recorded::RecordingReader file{folder / "first.nxs"};
        return file.text("start_time") + " to " + file.text("end_time");
    };
    EXPECT_EQ(end_time(true), end_time(false));
}

TEST(OnCallTest, WaitingDoesNotGrowMemory) {
    const auto folder = test::fresh_folder();
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser keeps what was freed";
    std::vector<std::size_t> pages;  // resident pages, every 10 s
    const auto look = [&](BenchPort&) {
        std::size_t size = 0, resident = 0;
        std::ifstream{"/proc/self/statm"} >> size >> resident;
        pages.push_back(resident);
    };
    std::vector<test::Move> moves;
    for (int k = 1; k <= 8; ++k)
        moves.push_back({[k](const BenchState& s) { return s.now_s > 10 * k; }, look});
    static_cast<void>(play_on_call(slow, quick(), folder, moves, 100));
    ASSERT_EQ(pages.size(), 8U);
    EXPECT_LT(pages[7], pages[3] + pages[3] / 200) << "from 40 s to 80 s";
}

TEST(OnCallTest, LoweredLimitsTrip) {
    const auto folder = test::fresh_folder();
    Answers answers;
    const auto lowered = orders(LowerLimit{{&safety::Limits::acceleration}, 8}, answers);
    const auto r = play_on_call(slow, quick(), folder,
                                {{in(run::RunState::idle), orders(Begin{10}, answers)},
                                 {in(run::RunState::run), lowered},
                                 {in(run::RunState::tripped), [](BenchPort&) {}}});
    EXPECT_EQ(answers, (Answers{"", ""}));
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::acceleration);
}

}  // namespace
}  // namespace shaker::service
