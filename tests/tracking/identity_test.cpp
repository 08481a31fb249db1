// Seven identical, equally spaced dots: no dot may be mistaken for its neighbour.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "drivers/errors.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/tracking/tracking_scene.hpp"

namespace shaker::tracking {
namespace {

constexpr int dots = 7;
constexpr double spacing = 80, radius = 5;  // as 160 px and 10 px in a picture of half the size

View row_of_dots(int from, int to) {
    View view;
    view.camera = "beam";
    view.mm_per_px = 1;
    for (int k = from; k < to; ++k) {
        Target dot{"dot" + std::to_string(k), TargetKind::dots};
        dot.diameter_mm = 2 * radius;
        dot.roi_px = {static_cast<int>(150 + spacing * k) - 12, 13, 24, 24};
        dot.polarity = Polarity::dark;
        view.targets.push_back(dot);
    }
    return view;
}

test::Shot picture(double shift, const std::vector<int>& hidden, std::mt19937_64& random) {
    test::TestPicture p{780, 50, 150};
    for (int k = 0; k < dots; ++k) p.disc({150 + spacing * k + shift, 25.0}, radius, 40, 0.8);
    for (const int k : hidden) {
        const int x = static_cast<int>(150 + spacing * k + shift);
        p.cover({x - 20, 0, x + 20, 50}, 150);
    }
    return p.expose({.noise = 2}, random);
}

struct Count {
    int right = 0, wrong = 0, lost = 0, wrong_ok = 0, beyond = 0;  // beyond three stated errors
};

// Free swing of 45 px amplitude at five frames per period, with random phases and occasional jerks: steps of
// up to 60 px, three quarters of the spacing.
template <class Hidden>
Count swing(const View& view, int first, Hidden hidden, std::uint64_t seed) {
    std::mt19937_64 random{seed};
    std::uniform_real_distribution<double> jump{-60, 60};
    ViewTracker tracker{view};
    Count count;
    // A patch is followed by the middle of its region of 24 px.
    const double first_at = view.targets.front().kind == TargetKind::patch ? 149.5 : 150;
    double shift = 0;
    for (int i = 0; i < 120; ++i) {
        const auto shot = picture(shift, hidden(i), random);
        const auto fixes = tracker.update(shot.view(), CameraTick{i});
        for (std::size_t k = 0; k < fixes.size(); ++k) {
            const double truth = first_at + spacing * (first + static_cast<int>(k)) + shift;
            if (!found(fixes[k].state))
                ++count.lost;
            else if (std::abs(fixes[k].x_px - truth) < 0.5)
                ++count.right;
            else {
                ++count.wrong;
                count.wrong_ok += !doubtful(fixes[k].state);
                count.beyond += std::abs(fixes[k].x_px - truth) > 3 * fixes[k].sd_px;
            }
        }
        const double step = jump(random);
        shift += std::abs(shift + step) < 45 ? step : (std::abs(shift - step) < 45 ? -step : 0);
    }
    std::printf("right %d, lost %d, wrong %d (ok %d, beyond the error %d)\n", count.right, count.lost,
                count.wrong, count.wrong_ok, count.beyond);
    return count;
}

TEST(IdentityTest, KeepsDotsThatJumpThreeQuartersOfSpacing) {
    const Count count = swing(
        row_of_dots(0, dots), 0, [](int) { return std::vector<int>{}; }, 1);
    EXPECT_EQ(count.wrong, 0);
    EXPECT_EQ(count.lost, 0);
}

// With an end hidden, a row shifted by one place fits as well as the row itself: better lost than wrong.
TEST(IdentityTest, HiddenEndNeverSwapsNames) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        const auto hand = [](int i) { return i % 30 > 20 ? std::vector<int>{6} : std::vector<int>{}; };
        EXPECT_EQ(swing(row_of_dots(0, dots), 0, hand, seed).wrong, 0) << "seed " << seed;
        const auto two = [](int i) { return i % 25 > 18 ? std::vector<int>{0, 3} : std::vector<int>{}; };
        EXPECT_EQ(swing(row_of_dots(0, dots), 0, two, seed).wrong, 0) << "seed " << seed;
    }
}

TEST(IdentityTest, KeepsNamesAfterFullCover) {
    const auto hand = [](int i) {
        return i % 40 > 32 ? std::vector<int>{0, 1, 2, 3, 4, 5, 6} : std::vector<int>{};
    };
    const Count count = swing(row_of_dots(0, dots), 0, hand, 9);
    EXPECT_EQ(count.wrong, 0);
    EXPECT_LE(count.lost, 7 * 3 * 8);
}

// Only one of the seven dots is a target: the other ones still prevent a mix-up.
TEST(IdentityTest, LookAlikesDoNotReplaceTheTarget) {
    const Count count = swing(
        row_of_dots(3, 4), 3, [](int) { return std::vector<int>{}; }, 2);
    EXPECT_EQ(count.wrong, 0);
    EXPECT_EQ(count.lost, 0);
}

// The same as patches, which may have to stay lost; a hand hides all dots, an end, or none.
TEST(IdentityTest, APatchIsNeverOnAnotherDotWhileItIsOk) {
    for (const auto& [from, to] : {std::pair{0, 1}, {2, 5}}) {
        View view = row_of_dots(from, to);
        for (Target& target : view.targets) target.kind = TargetKind::patch;
        const auto hand = [](int i) {
            return i % 40 > 32   ? std::vector<int>{0, 1, 2, 3, 4, 5, 6}
                   : i % 30 > 20 ? std::vector<int>{6}
                                 : std::vector<int>{};
        };
        for (int n = 0; n < test::plays(1, 20); ++n)
            EXPECT_EQ(swing(view, from, hand, 3 + static_cast<std::uint64_t>(n)).wrong_ok, 0);
    }
}

TEST(IdentityTest, TwoTargetsOnOneBlobAreRefused) {
    View view = row_of_dots(2, 3);
    view.targets.push_back(view.targets.front());
    view.targets.back().name = "again";
    std::mt19937_64 random{1};
    const auto shot = picture(0, {}, random);
    EXPECT_THROW(ViewTracker{view}.update(shot.view(), {}), InputError);
}

}  // namespace
}  // namespace shaker::tracking
