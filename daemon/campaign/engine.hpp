#pragma once
// Engine: which drive next. Leads a campaign from point to point by orders to a bench on call.
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "daemon/campaign/campaign_mu.hpp"
#include "daemon/campaign/journal.hpp"
#include "daemon/campaign/plan.hpp"
#include "daemon/campaign/travel.hpp"
#include "daemon/on_call/on_call.hpp"
#include "daemon/on_call/way_back.hpp"
#include "daemon/reduction/series.hpp"

namespace shaker::campaign {

/// The bench as the engine sees it, once a step.
struct Seen {
    double now_s = 0;                           // master time
    run::RunState state = run::RunState::init;  // OnCall::state()
    std::string trip{};                         // in state tripped: its cause and what to do
    bool may_start = false;                     // idle, and no stop is under way
    bool identified = true;                     // the response is known, or is not to be identified
    bool holding = false;                       // all measurements of the task are finished
    bool pending = false;                       // a finished measurement is not reduced yet
    double recorded_s = 0;                      // length of the open recording
    double free_bytes = INFINITY;               // of the disk; NaN: not known
    double bytes_per_s = 0.5e6;                 // of a recording
    double x_m = unknown;                       // newest position of the walker
    /// How far the walker's middle may go towards -x and +x, m; infinite on a bench that does not see it.
    std::array<double, 2> way{INFINITY, INFINITY};
};

// Orders to the bench.

/// From idle: a drive with a recording of its own.
struct Start {
    Drive drive;
    run::Task task;
};
/// In state run: a new set-point.
struct Change {
    Drive drive;
    run::Task task;
};
/// A soft stop.
struct Stop {};
using Action = std::variant<std::monostate, Start, Change, Stop>;

/// An event for the journal.
using Event = decltype(JournalEntry::what);

/// Words of the operator.
enum class Word { pause, resume, skip, repeat, stop };
inline constexpr std::array<std::string_view, 5> word_names{"pause", "resume", "skip", "repeat", "stop"};

struct EngineSettings {
    double mu = 0.113;     // friction coefficient by which walks are predicted at first
    double mu_target = 0;  // relative standard error of mu at which it ends; 0: all points
    double g = paper_g;    // m/s^2
    Timing timing{};
};

/// Pure: no device, no file, no clock. Thread safety: one thread.
///
/// A point is measured in one go if the walker's way allows it, else in passes. Before a pass that does not
/// fit into what is left, the walker returns: a move at a drive of its own. A point that fails is tried again
/// once, then left out. A trip, a refused start, a full disk pause the campaign until `resume`; the engine
/// never clears a trip. A pause stops a drive in whatever state it is. With a target for mu, the next point
/// is the one that helps most (MuChoice), and the campaign ends at the target.
class Engine {
public:
    /// ended: numbers of the points that need no further measurement. known: measured points, for mu_target.
    Engine(std::vector<Point> points, const EngineSettings& settings, const std::vector<int>& ended = {},
           const std::vector<law::Point>& known = {});

    /// The next order; nothing while the bench is on its way.
    Action next(const Seen& seen);
    /// A finished measurement of the bench.
    void take(const on_call::Measured& measured);
    /// The bench has refused the last order. That is no try of the point: a person decides.
    void refused(const std::string& why);
    /// The disk or another part of the computer has failed; a person must put it right.
    void failed(const std::string& what) { pause(what); }
    /// Ends as soon as the drive is silent.
    void leave() noexcept { leaving_ = true; }
    /// InputError when the word has no meaning now.
    void obey(Word word);

    /// The events since the last call, in order.
    std::vector<Event> events();
    /// All points have ended, or stop was ordered, and the drive is silent.
    [[nodiscard]] bool done() const noexcept { return done_; }
    [[nodiscard]] bool paused() const noexcept { return paused_; }
    /// v_D of a measured point, combined from its passes; NaN for any other.
    [[nodiscard]] calibration::Estimate result(int point) const;
    /// The point in progress, or the next one; null at the end.
    [[nodiscard]] const Point* point() const noexcept;
    [[nodiscard]] std::size_t ended() const noexcept { return ended_; }
    /// Whether each point has ended.
    [[nodiscard]] const std::vector<bool>& over() const noexcept { return over_; }
    [[nodiscard]] std::size_t points() const noexcept { return points_.size(); }
    [[nodiscard]] bool returning() const noexcept { return phase_ == Phase::returning; }
    /// "measuring", "returning", ...
    [[nodiscard]] std::string doing() const;
    /// The walk that is predicted for a drive.
    [[nodiscard]] run::PredictedWalk walk(const Drive& drive) { return walks_.prediction(drive); }
    /// With a target for mu: what is known of it, and how far that is from the target. Empty without one.
    [[nodiscard]] std::string known_mu() const { return choice_ ? choice_->sentence() : std::string{}; }
    /// The mu of the predictions.
    [[nodiscard]] double mu() const noexcept { return walks_.value(); }

private:
    enum class Phase { between, measuring, returning };
    Action choose(const Seen& seen);
    Action go(bool idle, const Drive& drive, const run::Task& task);
    Action halt(const std::string& why);
    Action lead_back(const Seen& seen, double v_D, double target);
    Action lead_to_middle(const Seen& seen, double ahead);
    Action watch_pass(const Seen& seen);
    Action watch_return(const Seen& seen);
    [[nodiscard]] int missing_periods() const;
    [[nodiscard]] std::string missed_precision() const;
    [[nodiscard]] std::string disk_is_short(const Seen& seen, const Travel& travel) const;
    void note_return();
    void repeat();
    void to_next();
    [[nodiscard]] double cost_s(std::span<const Point* const> points);
    void begin_point(const Point& point);
    void end_pass(const on_call::Measured& measured, PassEnded::How how, std::string reason);
    void take_loss();
    void lose_pass(const std::string& reason);
    void end_point(Outcome outcome, std::string reason);
    void fail(const std::string& reason);
    void pause(std::string reason);

    std::vector<Point> points_;
    std::vector<bool> over_;  // one for each point
    ReturnDrives returns_by_;
    EngineSettings settings_;
    LearnedMu walks_;
    std::optional<MuChoice> choice_;  // empty: the points come in their order
    std::size_t ended_ = 0;
    // The point in progress, or the next one.
    std::size_t at_ = 0;
    bool begun_ = false;
    int tries_ = 0;  // that failed
    int pass_ = 0;
    double ordered_s_ = 0;                       // master time of the order of the pass
    double x_from_m_ = unknown, x_m_ = unknown;  // of the walker: at the order of the pass, now
    std::array<double, 2> way_{INFINITY, INFINITY};
    int asked_periods_ = 0;                     // of the pass
    int measured_ = 0;                          // periods, of the point
    std::vector<reduction::PassDrift> passes_;  // of the point
    int returns_ = 0;                           // without a pass between them
    Phase phase_ = Phase::between;
    bool centred_ = false;    // led to the middle before the response was identified
    double frequency_ = 0;    // of the drive, Hz
    bool under_way_ = false;  // the bench was seen in state run since the last order from idle
    std::string early_;       // why the pass ended early
    std::string lost_;        // why the drive under way has ended, which a measurement may still follow
    bool taken_ = false;      // the pass has given a measurement
    on_call::WayBack way_back_;
    std::vector<int> told_passes_;  // of this point that the journal has
    struct {
        int point = 0;  // 0: none
        std::vector<int> passes{};
    } last_{};              // the point that ended last
    bool tripped_ = false;  // a trip that is not cleared
    bool paused_ = false, stop_ = false, leaving_ = false, done_ = false;
    std::vector<Event> events_;
    std::map<int, calibration::Estimate> results_;  // of measured points
};

}  // namespace shaker::campaign
