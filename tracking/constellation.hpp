#pragma once
// Which look-alike is which: all of them moved together, or nobody is named.
#include <span>
#include <vector>

#include "tracking/locator.hpp"

namespace shaker {

/// Look-alike targets of one view, with the look-alikes nobody asked for as companions. In every frame one
/// common displacement (with a small turn and stretch) has to carry the members to the candidates: hypotheses
/// are ranked by how far the candidates are off, by members that should be in view and are not, and by
/// candidates left over. When a second hypothesis that names somebody differently is nearly as good, nobody
/// is named. Between frames members move less than 0.8 of the distance to their neighbour.
class Constellation {
public:
    static constexpr int nobody = -1;

    /// Places in frame 0; `radius` is how much of a member must be inside the image to be expected there.
    Constellation(std::span<const Point> places, std::size_t targets, double radius);
    /// Index of each target's candidate, or nobody. `frames` have passed since the last call.
    std::span<const int> assign(std::span<const Candidate> candidates, int width, int height, double frames);

private:
    struct Member {
        Point at, velocity;
        double neighbour = 0;  // distance to the nearest one in frame 0
        double unseen = 0;     // frames
        bool gone = false;     // companions that stay away are forgotten
    };
    struct Hypothesis {
        std::vector<int> chosen;
        double cost = 0;
        int named = 0, expected = 0;
        Point moved;
    };

    [[nodiscard]] Hypothesis try_displacement(Point displacement, std::span<const Candidate> candidates,
                                              int width, int height, double frames) const;
    [[nodiscard]] double misfit(const std::vector<int>& chosen, std::span<const Candidate> candidates,
                                double frames) const;
    [[nodiscard]] bool contradict(const Hypothesis& a, const Hypothesis& b) const;
    [[nodiscard]] bool convincing(const Hypothesis& best) const;
    void follow(const Hypothesis& best, std::span<const Candidate> candidates, double frames);
    void miss(double frames);

    std::vector<Member> members_;
    std::size_t targets_;
    double radius_;
    std::vector<int> chosen_;
};

}  // namespace shaker
