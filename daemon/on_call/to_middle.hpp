#pragma once
// ToMiddle: leads the walker to the middle of the picture by a drive of its own, from rest to rest.
#include <functional>
#include <string>
#include <vector>

#include "daemon/on_call/way_back.hpp"
#include "daemon/run/sequence.hpp"
#include "daemon/run/walk_prediction.hpp"
#include "daemon/run/walker_monitor.hpp"
#include "drivers/drive.hpp"

namespace shaker::on_call {

/// Thread safety: one thread.
class ToMiddle {
public:
    struct Way {
        Drive drive;
        run::PredictedWalk walk;  // expected of it
        run::Task task;           // a move; a walker near the edge is moved before the response is identified
    };
    /// Throws InputError for a drive beyond the limits.
    using RequirePossible = std::function<void(const Drive&)>;
    /// The weakest of a few drives at `frequency` (Hz) that certainly lead the walker to the middle: phi 0 or
    /// pi, rho 0.5, gamma from 1 g on. Walks are predicted by `points` and `mu`; if neither is known, for any
    /// usual friction. g in m/s^2. edge_mm: limit. InputError without a walker in a picture, for a walker
    /// in the middle, and when no drive within the limits leads there.
    static Way way(const run::WalkerMonitor& walker, double edge_mm, double frequency,
                   const std::vector<reduction::DrivenPoint>& points, const calibration::Estimate& mu,
                   double g, const RequirePossible& require_possible);

    /// The drive of this way was ordered.
    void begin(const Way& way) noexcept { way_ = way, state_ = State::starts, trouble_.clear(); }
    /// From begin() until end() or give_up().
    [[nodiscard]] bool active() const noexcept { return state_ != State::none; }
    /// Follows a drive in force. True, once: it is to stop, because the walker arrives, does not come, or
    /// goes the other way.
    bool over(double now_s, const run::WalkerMonitor& walker, double edge_mm);
    /// The drive is silent again: where the walker is, for the log.
    std::string end(const run::WalkerMonitor& walker, double edge_mm);
    /// A trip has ended it.
    void give_up() noexcept { state_ = State::none, way_back_.abandon(); }

private:
    enum class State { none, starts, goes, stops };

    State state_ = State::none;
    Way way_{};
    WayBack way_back_;
    double least_way_m_ = 0;  // that a walker on the right way has ahead
    std::string trouble_;
};

}  // namespace shaker::on_call
