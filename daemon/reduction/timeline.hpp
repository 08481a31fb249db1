#pragma once
// A period of the walker as a Kalman filter sees it: what the acceleration may do, and what the positions
// make of it.
#include <Eigen/Core>
#include <span>
#include <vector>

#include "daemon/reduction/cycle.hpp"

namespace shaker::reduction {

using MotionState = Eigen::Vector4d;  // x, v, a, and the jerk within a zone; units of Scales
using MotionMatrix = Eigen::Matrix4d;

/// A phase in order: a position, a phase asked for, or both.
struct Node {
    double p = 0;
    bool seen = false;
    double x = 0, variance = 1;  // of the position, units of Scales
    int wanted = -1;             // index of the phase asked for
};

/// The interval in which the acceleration changes, in periods.
struct Zone {
    double middle = 0, length = 0;
    bool rests_after = false;
};

/// Up to phase `to` the acceleration wanders with this intensity, within a zone about a straight change; at
/// `to` it jumps.
struct Stretch {
    double to = 0, intensity = 0, jump = 0, jerk = 0;  // units of Scales; jump and jerk: variances
    bool rests = false;
};

/// Wandering in a zone, as a share of the change: it need not be straight.
inline constexpr double shape = 0.45;

/// Units near 1: the interval of the frames, and the error of one position.
struct Scales {
    double t_s = 1, x_m = 1;
};

/// How friction wanders, at uniform phases: it depends on v_R, the more the smaller |v_R| is.
struct Looseness {
    std::vector<double> share{};  // of the mean intensity
    std::vector<double> more{};   // intensity, units of Scales, where slips and sticks are not resolved
};

/// Positions in order of phase, with stretches of slip, rest and change between them.
class Timeline {
public:
    /// jump: standard deviation of a change of the acceleration. blur: a position is x + blur a, the mean
    /// over its exposure. Units of Scales. base and loose must outlive it.
    Timeline(const BaseCycle& base, Scales scales, double jump, double blur, const Looseness& loose);

    [[nodiscard]] double jump() const { return jump_; }
    [[nodiscard]] double period() const { return period_; }  // in units of time

    /// -2 ln likelihood of the positions, but for a constant. The first ones fix the start. intensity: of the
    /// wandering outside the zones.
    [[nodiscard]] double misfit(std::span<const Node> nodes, std::span<const Zone> zones,
                                double intensity) const;
    /// Adds v and v^2 + variance of the smoothed motion at the phases asked for.
    void smooth(std::span<const Node> nodes, std::span<const Zone> zones, double intensity,
                std::vector<double>& first, std::vector<double>& second) const;

private:
    [[nodiscard]] std::vector<Stretch> stretches(std::span<const Zone> zones, double intensity, double from,
                                                 double to) const;
    MotionMatrix advance(MotionState& m, MotionMatrix& P, double from, double to,
                         std::vector<Stretch>::const_iterator& at) const;
    double observe(MotionState& m, MotionMatrix& P, const Node& n) const;
    MotionMatrix step(MotionState& m, MotionMatrix& P, double from, double to, const Stretch& s) const;

    const BaseCycle& base_;
    double period_;
    Scales scales_;
    double jump_;
    double blur_;
    const Looseness& loose_;
};

}  // namespace shaker::reduction
