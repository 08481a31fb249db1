#pragma once
// Campaign: leads a runner on call through a plan. And its events in words, for the terminal and the log.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/campaign/engine.hpp"
#include "daemon/on_call/on_call.hpp"

namespace shaker::campaign {

/// Master time of a campaign by its use, s. A pause counts only while the base is driven.
struct BenchTime {
    double measuring = 0, settling = 0, returning = 0;
    double checking = 0;  // self-test, loop checks, ramps from and to rest, completion of recordings
    [[nodiscard]] double sum() const noexcept { return measuring + settling + returning + checking; }
};

struct CampaignSettings {
    run::RunOptions run;           // rig, pictures, identification of every drive
    std::filesystem::path folder;  // of the recordings
    int recordings = 0;            // that are in the folder already
    double edge_margin_mm = 2;     // inside the limit at the edge; a pass ends here
};

/// Thread safety: one thread. Runner, bench on call and engine must outlive this object.
class Campaign {
public:
    using Listener = std::function<void(const Event&, double now_s)>;
    Campaign(run::Runner& runner, on_call::OnCall& on_call, Engine& engine, const CampaignSettings& settings,
             Listener listener);

    /// A finished measurement of the bench.
    void take(const on_call::Measured& measured) { engine_.take(measured); }
    /// Gives the bench the engine's next order. Call it between OnCall::take() and OnCall::follow().
    void order(acquisition::Channels& channels);
    /// A run whose recording is complete.
    void take(const run::FinishedRun& run);
    /// Counts the time and reports the events. Call it after OnCall::follow().
    void follow();
    /// The engine has ended, the drive is silent and all recordings are complete.
    [[nodiscard]] bool done() const { return engine_.done() && on_call_.at_rest(); }
    /// Paused, and nothing happens before a person gives a word.
    [[nodiscard]] bool waits_for_a_person() const {
        return engine_.paused() && on_call_.at_rest() &&
               (on_call_.state() == run::RunState::idle || on_call_.may_clear());
    }
    /// The newest drive that was ordered.
    [[nodiscard]] const Drive& drive() const noexcept { return drive_; }
    [[nodiscard]] const BenchTime& time() const noexcept { return time_; }

private:
    [[nodiscard]] Seen seen(const acquisition::Channels& channels) const;
    [[nodiscard]] double pictures_per_s() const;  // bytes/s that the cameras add to a recording
    void count_time();
    void finish_start();
    void carry_out(const Action& action, acquisition::Channels& channels);

    run::Runner& runner_;
    Engine& engine_;
    CampaignSettings settings_;
    Listener listener_;
    on_call::OnCall& on_call_;
    Drive drive_;
    bool starts_ = false;          // the recording of a start is being opened
    double recording_from_s_ = 0;  // master time of the newest start
    BenchTime time_;
    double timed_to_s_ = 0;
};

/// Series and drive of a point: "pair 20 Hz gamma 9.8 m/s^2 rho 0.5 phi 35.0 deg".
std::string place(const Point& point);
/// The event as one sentence; empty for one that a person need not read. points: of the engine, in their
/// order.
std::string text(const Event& event, const Engine& engine, const std::vector<Point>& points);

}  // namespace shaker::campaign
