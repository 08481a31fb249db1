// A bench on call whose targets are not in their regions at the start: it shows its pictures, refuses to
// drive, and goes on when they are found.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::in;
using test::until;

class FindTargetsTest : public test::OnCallBench {
protected:
    /// Idle, with the first pictures, and the targets of the camera "top" not found.
    [[nodiscard]] static bool misses(const BenchState& s) {
        return s.state == RunState::idle && s.pictures_now.at(0).frame &&
               !s.pictures_now[0].not_found.empty();
    }
    [[nodiscard]] static bool finds(const BenchState& s) {
        return s.state == RunState::idle && s.pictures_now.at(0).not_found.empty() &&
               !s.pictures_now[0].fixes.empty();
    }
};

// The walker's region is 70 px beside it.
TEST_F(FindTargetsTest, AMovedRegionLetsTheBenchDrive) {
    std::array<double, 4> right{};
    const auto r =
        play("[top]\nframe_rate_hz = 200\nregion_off_px = 70\n[side]\nframe_rate_hz = 200\n",
             {until([&](const BenchState& s) {
                  if (!misses(s)) return false;
                  EXPECT_TRUE(s.pictures_now[1].not_found.empty()) << s.pictures_now[1].not_found;
                  EXPECT_EQ(s.pictures_now[0].regions_now, decltype(s.pictures_now[0].regions_now)(2));
                  std::ranges::copy(s.facts->views.at(0).targets.at(0).roi_px, right.begin());
                  right[0] -= 70;
                  return true;
              }),
              start(),
              {in(RunState::idle), give(Identify{})},
              {in(RunState::idle),
               [&](BenchPort& port) {
                   give(MoveTargets{{{"top", "walker", right}}})(port);
               }},
              {finds, give(Begin{10})},
              {test::measured(1), give(End{})},
              until(in(RunState::idle))});
    ASSERT_EQ(answers.size(), 5U) << test::log_of(r);
    for (const std::size_t refused : {0U, 1U})
        for (const char* words :
             {" cannot start: camera top, target walker, roi_px", "move its region onto it"})
            EXPECT_NE(answers[refused].find(words), std::string::npos) << answers[refused];
    for (const std::size_t done : {2U, 3U, 4U}) EXPECT_EQ(answers[done], "");
    EXPECT_EQ(r.last.points.size(), 1U) << test::log_of(r);
    const std::string log = test::log_of(r);
    EXPECT_NE(log.find("camera top, target walker, roi_px"), std::string::npos) << log;
    EXPECT_NE(log.find("camera \"top\": its targets are found"), std::string::npos) << log;
}

// The walker is put on the base after the start of the daemon.
TEST_F(FindTargetsTest, ATargetThatComesIsFound) {
    double found_s = 0;
    const auto r = play(test::rendered + test::fault("walker_hidden", 0, "for_s = 3\ncamera = \"top\"\n"),
                        {until(misses),
                         until([&](const BenchState& s) {
                             if (finds(s)) found_s = s.now_s;
                             return found_s > 0;
                         }),
                         start(),
                         {test::measured(1), give(End{})},
                         until(in(RunState::idle))});
    EXPECT_EQ(answers, test::Answers(2, "")) << test::log_of(r);
    EXPECT_GE(found_s, 3);
    EXPECT_LE(found_s, 3.5) << "searched in every 50th picture";
    EXPECT_EQ(r.last.points.size(), 1U) << test::log_of(r);
}

}  // namespace
}  // namespace shaker::service
