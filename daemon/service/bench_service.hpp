#pragma once
// A bench on call: idle until it is ordered to drive, for weeks. Leads the director, keeps the orders'
// conditions, has measurements reduced and recorded, and publishes what the bench is at.
#include <array>
#include <atomic>
#include <cmath>
#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>

#include "daemon/run/runner.hpp"
#include "daemon/service/bench_port.hpp"

namespace shaker::service {

class StateBuilder;

struct BenchServiceSettings {
    bool beside = false;                 // measurements are reduced in a thread beside this one
    calibration::Estimate mu{NAN, NAN};  // of walker and base, where it is known
};

/// All of it on the reduction's thread. The runner, which is on call, and the port outlive this.
class BenchService {
public:
    /// What the runner's options ask for is wanted at first; identify, mains, pictures for good.
    BenchService(run::Runner& runner, const BenchServiceSettings& settings, BenchPort& bench_port);
    ~BenchService();
    BenchService(const BenchService&) = delete;
    BenchService& operator=(const BenchService&) = delete;

    /// After new data: answers orders, goes on, publishes. False when nothing had come.
    bool step(const acquisition::Streams& streams, acquisition::Channels& channels);
    /// To be over as soon as the drive has come down softly and what is recorded is finished. Any thread.
    void leave() noexcept { leaving_ = true; }
    [[nodiscard]] bool leaving() const noexcept { return leaving_; }
    /// It has left.
    [[nodiscard]] bool done() const noexcept { return done_; }

private:
    /// A reduction, or why there is none.
    using Outcome = std::variant<std::shared_ptr<const reduction::Reduction>, std::string>;

    bool answer(acquisition::Channels& channels);
    void obey(const SetDrive& order, acquisition::Channels& channels);
    void obey(const Begin& order, acquisition::Channels& channels);
    void obey(const Identify& order, acquisition::Channels& channels);
    void obey(const End& order, acquisition::Channels& channels);
    void obey(const ClearTrip& order, acquisition::Channels& channels);
    void obey(const Record& order, acquisition::Channels& channels);
    void obey(const Remark& order, acquisition::Channels& channels);
    void obey(const CloseLoop& order, acquisition::Channels& channels);
    void obey(const LowerLimits& order, acquisition::Channels& channels);
    void obey(const Adopt& order, acquisition::Channels& channels);
    void require_possible(const Drive& drive, const safety::Limits& limits) const;
    void take_limits(const safety::Limits& limits, acquisition::Channels& channels);
    void measure(const acquisition::Streams& streams);
    void take_outcome();
    void compare_points();
    void follow_states();
    void go_away(acquisition::Channels& channels);
    void tidy(acquisition::Streams& streams) const;
    void tell_finished(const run::FinishedRun& run);
    void tell_warnings(const acquisition::Channels& channels);
    void tell(std::string kind, const std::string& text);
    void publish();

    bench::Bench& bench_;
    acquisition::Collector& collector_;
    run::RunOptions run_;
    recorded::KeptPictures opened_;  // what the cameras were opened for
    bool beside_;
    BenchPort& bench_port_;
    safety::Limits limits_;
    run::Sequence& sequence_;
    run::Recordings& record_;
    std::unique_ptr<StateBuilder> report_;
    bool armed_ = false;     // a drive was asked for since nothing was driven last
    bool recorded_ = false;  // the next run is
    std::string name_;       // of that recording; empty: by the time
    std::uint64_t answered_ = 0;
    run::RunState state_ = run::RunState::init;
    bool active_ = false, stop_told_ = false;  // a run that is not finished; why it was stopped was recorded
    std::size_t measured_ = 0, told_notes_ = 0;
    std::array<std::uint64_t, safety::causes> warnings_{};  // counts when they were looked at last
    std::set<std::string> warned_;                          // in this run, by cause
    std::uint64_t not_learned_ = 0;                         // that was told
    struct Pending {
        Drive asked;
        recording::MeasuredPart part;
        std::future<Outcome> outcome;
    };
    std::deque<Pending> pending_;
    std::shared_ptr<const reduction::Reduction> result_;
    ResultOrigin origin_;  // of that; its number goes on when a new run takes the result away
    std::string not_reduced_;
    double measured_from_s_ = NAN;  // of what is either
    std::shared_ptr<const BenchFacts> facts_;
    std::vector<reduction::DrivenPoint> points_;
    std::vector<recording::MeasuredPart> parts_;
    std::optional<reduction::MirrorPair> mirror_;
    std::optional<reduction::NullPhase> null_;
    std::vector<double> closed_form_;
    calibration::Estimate mu_;
    std::vector<safety::Demand> predicted_;
    std::shared_ptr<const control::IdentifiedResponse> response_;
    std::atomic<bool> leaving_{false};
    bool done_ = false, changed_ = true;
    double published_s_ = 0, trip_s_ = 0;
};

}  // namespace shaker::service
