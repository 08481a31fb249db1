#pragma once
// Constellation: assigns candidates to look-alike targets by their common displacement.
#include <span>
#include <vector>

#include "tracking/locator.hpp"

namespace shaker::tracking {

/// Look-alike targets of one view, with unnamed look-alikes as companions. In every frame one common
/// displacement (with a small rotation and stretch) must map the members to the candidates. The cost of a
/// hypothesis: distances of the candidates, members that should be in view but are missing, candidates left
/// over (more if their places were in view in frame 0, and empty), a move in a gap that is larger than its
/// earlier motion explains. If a second hypothesis with a different assignment has almost the same cost, no
/// target is assigned. Between frames members move less than 0.8 of the distance to their neighbour.
class Constellation {
public:
    static constexpr int nobody = -1;

    /// Positions in frame 0. radius: px; a member is expected in the image if it is inside by this much.
    Constellation(std::span<const Point> places, std::size_t targets, double radius);
    /// Index of the candidate of each target, or `nobody`. frames: number of frames since the last call.
    std::span<const int> assign(std::span<const Candidate> candidates, int width, int height, double frames);
    /// Standard error of the places while the names were settled, after a long gap, only because a move is
    /// less likely than none: half of the least distance of two members, px; else 0.
    [[nodiscard]] double doubt_px() const noexcept;
    /// Predicted places of all members, targets first; NaN: a companion that has gone. Empty when a member
    /// was not seen in the last frame.
    std::span<const Point> expected(double frames);
    /// Instead of assign(), when each member was found at its place in expected(): another assignment would
    /// miss a member and leave a candidate over. False when a candidate is off its place, or off the others;
    /// then assign() decides.
    bool confirm(std::span<const Candidate> found, double frames);

private:
    struct Member {
        Point at, velocity;
        double neighbour = 0;  // px, distance to the nearest one in frame 0
        double unseen = 0;     // frames since last seen
        bool gone = false;     // a companion that stays away is not missed
        Point began;           // place in frame 0
    };
    struct Hypothesis {
        std::vector<int> chosen;
        double cost = 0, haste = 0;  // with the part for a move that is too large
        int named = 0, expected = 0;
        Point moved;
    };

    static double off_place(const Member& m) noexcept;
    [[nodiscard]] Hypothesis try_displacement(Point displacement, std::span<const Candidate> candidates,
                                              int width, int height, double frames) const;
    void weigh(Hypothesis& h, std::span<const Candidate> candidates, std::span<const int> owner, int width,
               int height, double frames) const;
    [[nodiscard]] bool too_far(const Member& m, Point to, double frames) const;
    [[nodiscard]] double misfit(const std::vector<int>& chosen, std::span<const Candidate> candidates,
                                double frames) const;
    [[nodiscard]] bool contradict(const Hypothesis& a, const Hypothesis& b) const;
    [[nodiscard]] bool convincing(const Hypothesis& best) const;
    void follow(const Hypothesis& best, std::span<const Candidate> candidates, double frames);
    void miss(double frames);

    std::vector<Member> members_;
    bool doubts_ = false;
    double fastest_ = 0,
           farthest_ = 0;  // step of a member in a frame; distance from its place in frame 0, px
    double watched_ = 0;   // frames in which members were found
    std::size_t targets_;
    double radius_;
    std::vector<int> chosen_;
    std::vector<Point> expected_;
};

}  // namespace shaker::tracking
