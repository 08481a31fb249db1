#pragma once
// The walker's position and drift during a run, from the first working camera that tracks it.
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/reduction/period_fold.hpp"

namespace shaker::run {

class WalkerMonitor {
public:
    explicit WalkerMonitor(double frequency) : frequency_{frequency}, fold_{0, 1 / frequency} {}
    /// Adds the tracks that arrived since the last call.
    void add(const acquisition::Streams& streams);
    /// True when a working camera tracks the walker.
    [[nodiscard]] bool watches() const noexcept { return watches_; }
    /// True when a camera that tracks the walker has failed and no other one tracks it.
    [[nodiscard]] bool blind() const noexcept { return blind_; }
    /// True when the drifts of whole periods since `from_s` (s) have settled to 1e-4 V / f, with
    /// V = gamma / (2 pi f); gamma in m/s^2.
    [[nodiscard]] bool settled_since(double from_s, double gamma) const;
    /// Master time of the newest track, s.
    [[nodiscard]] double until_s() const noexcept { return until_s_; }
    /// Newest position, m; empty before the walker was found.
    [[nodiscard]] std::optional<double> x_m() const noexcept { return x_m_; }
    /// Smaller distance of the walker's outline from the two ends of the picture along the shaker's axis, mm;
    /// empty before the walker was found.
    [[nodiscard]] std::optional<double> edge_mm() const noexcept { return edge_mm_; }
    /// The same, mean over the last period of the drive: without the walker's oscillation.
    [[nodiscard]] std::optional<double> mean_edge_mm() const noexcept;
    /// Direction along x from the nearer end of the picture to the middle, +1 or -1; 0 before the walker was
    /// found.
    [[nodiscard]] int inwards() const noexcept;
    /// x on the walker's line at the picture's left and right end, m (upper and lower end when the shaker's
    /// axis runs along the picture's height); NaN before the walker was found.
    [[nodiscard]] std::array<double, 2> ends_m() const noexcept { return ends_m_; }
    /// Consecutive frames without the walker.
    [[nodiscard]] int lost() const noexcept { return lost_; }
    /// Processed tracks.
    [[nodiscard]] std::size_t seen() const noexcept { return seen_; }

private:
    void follow(const acquisition::TargetTrack& walker);

    double frequency_;
    reduction::PeriodFold fold_;
    std::deque<reduction::PeriodFold::Period> drifts_;  // the newest, oldest first
    bool watches_ = false, blind_ = false;
    std::string camera_;  // that tracks it
    std::size_t seen_ = 0;
    double until_s_ = 0;
    std::optional<double> x_m_, edge_mm_;
    struct Edge {
        double at_s, mm;
    };
    std::deque<Edge> edges_;  // of the last period
    std::array<double, 2> ends_m_{NAN, NAN};
    int lost_ = 0;
};

}  // namespace shaker::run
