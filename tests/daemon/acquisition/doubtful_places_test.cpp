// A place that the tracker doubts reaches no result with full weight, whatever it says of its error.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "drivers/errors.hpp"
#include "tests/support/recording/long_run.hpp"

namespace shaker::acquisition {
namespace {

using reduction::Reduction;
using tracking::TrackState;

constexpr double everything = 1e300;

/// Every n-th place of a body, from the first on: off by `off_m`, told to be in doubt, with its old
/// error.
Streams doubted(const test::LongStreams& run, int n, double off_m, double sd_m = 0,
                const char* body = "walker", TrackState state = TrackState::degraded) {
    Streams streams = run.streams;
    for (TargetTrack& t : streams.tracks) {
        if (t.target.name != body) continue;
        for (std::size_t i = 0; i < t.tracks.size(); i += static_cast<std::size_t>(n)) {
            tracking::Track& place = t.tracks[i];
            if (!found(place.fix.state)) continue;
            place.fix.state = state;
            place.x_m += off_m;
            place.sd_m = std::hypot(place.sd_m, sd_m);
        }
    }
    return streams;
}

Reduction reduced(const test::LongStreams& run, const Streams& streams) {
    return reduce(measurement_of(streams, run.header.frequency_hz, -everything, everything));
}

bool notes(const Reduction& r, const char* words) {
    return std::ranges::any_of(
        r.notes, [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

TEST(DoubtfulPlacesTest, FewAreLeftOutAndTold) {
    const test::LongStreams run = test::make_long_streams({.seconds = 10, .lost = 0});
    const Reduction plain = reduced(run, run.streams), r = reduced(run, doubted(run, 11, 1e-3));
    EXPECT_NEAR(r.v_D.value, run.v_D, 4 * r.v_D.sigma);
    EXPECT_LT(r.v_D.sigma, 1.3 * plain.v_D.sigma);
    ASSERT_EQ(r.cycle.v_mps.size(), plain.cycle.v_mps.size());
    for (std::size_t i = 0; i < r.cycle.v_mps.size(); ++i)
        EXPECT_NEAR(r.cycle.v_mps[i], plain.cycle.v_mps[i],
                    5 * std::hypot(r.cycle.v_sd_mps[i], plain.cycle.v_sd_mps[i]));
    EXPECT_NEAR(r.frames_doubtful, (plain.frames + 10) / 11.0, 3);
    EXPECT_TRUE(notes(r, "the place of the walker is in doubt in ")) << r.notes.size();
    EXPECT_TRUE(notes(r, "these are excluded"));
    EXPECT_FALSE(r.degraded);
    EXPECT_EQ(plain.frames_doubtful, 0);
}

// With errors that cover the doubt, as a tracker states them for marks that may have slipped.
TEST(DoubtfulPlacesTest, MostOfThemCountAndDegradeTheResult) {
    const test::LongStreams run = test::make_long_streams({.seconds = 10, .lost = 0});
    const Reduction r = reduced(run, doubted(run, 1, 1e-3, 0.7e-3));
    EXPECT_EQ(r.frames_doubtful, r.frames);
    EXPECT_TRUE(std::isfinite(r.v_D.value));
    EXPECT_TRUE(r.degraded);
    EXPECT_TRUE(notes(r, "the result is degraded"));
}

TEST(DoubtfulPlacesTest, AViewInDoubtYieldsToAnother) {
    const test::LongStreams run = test::make_long_streams({.seconds = 10, .lost = 0});
    Streams streams = doubted(run, 1, 1e-3);
    int views = 0;
    for (std::size_t k = 0; k < streams.tracks.size(); ++k) {
        TargetTrack& t = streams.tracks[k];
        if (t.target.name != "walker") continue;
        if (++views > 1) t = run.streams.tracks[k];  // no doubt
        for (std::size_t i = 3000; views == 1 && i < t.tracks.size(); ++i) t.tracks[i].x_m += 1e-3;  // a slip
    }
    ASSERT_EQ(views, 2);
    const Reduction r = reduced(run, streams);
    EXPECT_FALSE(r.degraded);
    EXPECT_NEAR(r.v_D.value, run.v_D, 4 * r.v_D.sigma);
    EXPECT_TRUE(notes(r, "this view is left out"));
}

TEST(DoubtfulPlacesTest, ABaseInDoubtGivesNoResponse) {
    const test::LongStreams run = test::make_long_streams({.seconds = 10, .lost = 0});
    const double f = run.header.frequency_hz;
    EXPECT_FALSE(response_lines(measurement_of(run.streams, f, -everything, everything)).empty());
    try {
        response_lines(measurement_of(doubted(run, 1, 1e-3, 0, "base"), f, -everything, everything));
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string{error.what()}.find("the place of the base is in doubt"), std::string::npos);
    }
}

TEST(DoubtfulPlacesTest, NotesNameTheCauseAndWhatToDo) {
    const test::LongStreams run = test::make_long_streams({.seconds = 10, .lost = 0});
    const auto of = [&](TrackState state) {
        return reduced(run, doubted(run, 11, 1e-3, 0, "walker", state));
    };
    EXPECT_TRUE(notes(of(TrackState::degraded), " partly hidden, blurred, or of a body that turns), not in "));
    EXPECT_TRUE(notes(of(TrackState::clipped), " clipped), not in "));
    EXPECT_TRUE(notes(of(TrackState::clipped), "; shorten the exposure"));
    EXPECT_TRUE(notes(of(TrackState::slipped), " marks perhaps mistaken for their neighbours), not in "));
    const Reduction r = of(TrackState::repeated);
    EXPECT_EQ(r.frames_doubtful, 0);
    EXPECT_GT(r.frames_lost, 0);
    EXPECT_TRUE(notes(r, fmt::format("; {} of them repeat rows of an earlier frame", r.frames_lost).c_str()));
    EXPECT_NEAR(r.v_D.value, run.v_D, 4 * r.v_D.sigma);
}

TEST(DoubtfulPlacesTest, WithoutDoubtNothingChanges) {
    const test::LongStreams run = test::make_long_streams({.seconds = 10});
    const Reduction r = reduced(run, run.streams);
    EXPECT_EQ(r.frames_doubtful, 0);
    EXPECT_FALSE(notes(r, "in doubt"));
}

}  // namespace
}  // namespace shaker::acquisition
