#pragma once
// The walker's position and drift during a run, from one working camera that sends pictures of it.
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
    /// Adds the tracks that arrived since the last call. now_s: master time played. missing_s: longest time
    /// without a picture; at least 10 frames of the camera count. When the followed camera is silent for
    /// longer and another one is not, that one is followed; when none is left, the place is forgotten.
    /// A steady delay of a camera is not silence: the time between arrivals counts.
    void add(const acquisition::Streams& streams, double now_s, double missing_s);
    /// The DAC was silent for `silent_s` up to now_s. It triggers the cameras: that time is not theirs.
    void dac_was_silent(double silent_s, double now_s) noexcept;
    /// The drive's frequency from now on: the drifts restart.
    void set_frequency(double frequency);
    /// True when a working camera tracks the walker.
    [[nodiscard]] bool watches() const noexcept { return watches_; }
    /// True when a camera that tracks the walker has failed and no other one tracks it.
    [[nodiscard]] bool blind() const noexcept { return blind_; }
    /// True when a camera is there to track the walker, working or not.
    [[nodiscard]] bool has_target() const noexcept { return watches_ || blind_; }
    /// Time since the newest picture came, s, and the longest that is allowed.
    [[nodiscard]] double age_s() const noexcept { return age_s_; }
    [[nodiscard]] double most_age_s() const noexcept { return most_age_s_; }
    /// True when the walker was found in a picture that is not older than allowed.
    [[nodiscard]] bool sees() const noexcept { return watches_ && found_age_s_ <= most_age_s_; }
    /// The followed camera; empty before the first.
    [[nodiscard]] const std::string& camera() const noexcept { return camera_; }
    /// True when the drifts of whole periods since `from_s` (s) have settled to 3e-5 V / f, with
    /// V = gamma / (2 pi f); gamma in m/s^2.
    [[nodiscard]] bool settled_since(double from_s, double gamma) const;
    /// Drift of a period of the drive, m: mean of the newest five; empty before the first.
    [[nodiscard]] std::optional<double> drift_m() const noexcept;
    /// Master time of the newest track, s.
    [[nodiscard]] double until_s() const noexcept { return until_s_; }
    /// Newest position, m; empty before the walker was found, and when it is not seen any more.
    [[nodiscard]] std::optional<double> x_m() const noexcept { return x_m_; }
    /// Smaller distance of the walker's outline from the two ends of the picture along the shaker's axis, mm,
    /// less two standard errors of a doubtful place; empty as x_m().
    [[nodiscard]] std::optional<double> edge_mm() const noexcept { return edge_mm_; }
    /// The same, mean over the last period of the drive: without the walker's oscillation.
    [[nodiscard]] std::optional<double> mean_edge_mm() const noexcept;
    /// How far the walker may go towards -x and towards +x until its outline is `edge_mm` (mm) from the end
    /// of the picture, m: mean over the last period of the drive, negative beyond. NaN before the walker was
    /// found.
    [[nodiscard]] std::array<double, 2> ways_m(double edge_mm) const noexcept;
    /// Amplitude of the walker's oscillation in the last period of the drive, m. A walker at rest: 0 and the
    /// noise of positions.
    [[nodiscard]] double swing_m() const noexcept;
    /// Direction along x from the nearer end of the picture to the middle, +1 or -1; 0 before the walker was
    /// found.
    [[nodiscard]] int inwards() const noexcept;
    /// x on the walker's line at the picture's left and right end, m (upper and lower end when the shaker's
    /// axis runs along the picture's height); NaN before the walker was found.
    [[nodiscard]] std::array<double, 2> ends_m() const noexcept { return ends_m_; }
    /// Consecutive frames without the walker, or in which its place is in doubt by more than the distance
    /// from the end of the picture.
    [[nodiscard]] int lost() const noexcept { return lost_; }
    /// Processed tracks.
    [[nodiscard]] std::size_t seen() const noexcept { return seen_; }

private:
    /// The pictures of one track.
    struct Source {
        std::size_t taken = 0;
        double came_s = 0;  // master time played when the newest one came; at first the start
    };
    const acquisition::TargetTrack* choose(const acquisition::Streams& streams, double now_s,
                                           double missing_s);
    void follow(const acquisition::TargetTrack& walker);
    void forget_place() noexcept;

    double frequency_;
    reduction::PeriodFold fold_;
    std::deque<reduction::PeriodFold::Period> drifts_;  // the newest, oldest first
    bool watches_ = false, blind_ = false;
    std::string camera_;           // that is followed
    std::vector<Source> sources_;  // one for each track of the streams
    double age_s_ = 0, most_age_s_ = 0;
    double found_s_ = -INFINITY, found_age_s_ = INFINITY;  // of the newest picture that shows it
    std::size_t seen_ = 0;
    double until_s_ = 0;
    std::optional<double> x_m_, edge_mm_;
    struct Edge {
        double at_s, mm, x_m;
    };
    std::deque<Edge> edges_;  // of the last period
    std::array<double, 2> ends_m_{NAN, NAN};
    double half_mm_ = 0;  // of the outline's extent
    int lost_ = 0;
};

/// Periods of the drive until the outline of a walker crosses the edge limit. ways_m: as
/// WalkerMonitor::ways_m(). walk_m: its way in a period, with the sign of x. swing_m: amplitude of its
/// oscillation. Not negative; infinite for a walker that stays where it is; NaN when the ways are not known.
double periods_to_edge(const std::array<double, 2>& ways_m, double walk_m, double swing_m) noexcept;

}  // namespace shaker::run
