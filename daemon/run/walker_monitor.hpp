#pragma once
// The walker as the first camera sees it while the run is on: whether its drift has settled, where it is.
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/reduction/period_fold.hpp"

namespace shaker::run {

class WalkerMonitor {
public:
    explicit WalkerMonitor(double frequency) : frequency_{frequency}, fold_{0, 1 / frequency} {}
    /// What came since the last call.
    void add(const acquisition::Streams& streams);
    /// Tracks of a walker are being made.
    [[nodiscard]] bool watches() const noexcept { return watches_; }
    /// Drifts of whole periods since `from_s` have settled, to one ten-thousandth of V / f at this gamma.
    [[nodiscard]] bool settled_since(double from_s, double gamma) const;
    /// Master time up to which tracks have come.
    [[nodiscard]] double until_s() const noexcept { return until_s_; }
    /// Newest position, m; empty before the first.
    [[nodiscard]] std::optional<double> x_m() const noexcept { return x_m_; }
    /// Least distance of its outline from the ends of the picture along the shaker's axis, mm; empty before
    /// it was seen.
    [[nodiscard]] std::optional<double> edge_mm() const noexcept { return edge_mm_; }
    /// x at the picture's left and right end, m, on the walker's line (at its upper and lower end, where the
    /// shaker's axis runs along the picture's height); NaN before the walker was seen.
    [[nodiscard]] std::array<double, 2> ends_m() const noexcept { return ends_m_; }
    /// Frames in a row in which it was not found.
    [[nodiscard]] int lost() const noexcept { return lost_; }
    /// Tracks seen so far.
    [[nodiscard]] std::size_t seen() const noexcept { return seen_; }

private:
    double frequency_;
    reduction::PeriodFold fold_;
    std::deque<reduction::PeriodFold::Period> drifts_;  // the newest
    bool watches_ = false;
    std::size_t seen_ = 0;
    double until_s_ = 0;
    std::optional<double> x_m_, edge_mm_;
    std::array<double, 2> ends_m_{NAN, NAN};
    int lost_ = 0;
};

}  // namespace shaker::run
