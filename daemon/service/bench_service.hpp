#pragma once
// A bench on call: idle until a client orders a run, for weeks. Leads the sequence, checks and carries out
// orders, has measurements reduced and recorded, and publishes the state of the bench.
#include <array>
#include <atomic>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "daemon/on_call/on_call.hpp"
#include "daemon/on_call/to_middle.hpp"
#include "daemon/run/runner.hpp"
#include "daemon/run/walk_prediction.hpp"
#include "daemon/service/bench_port.hpp"
#include "daemon/service/campaign_host.hpp"
#include "daemon/service/live_mu.hpp"
#include "drivers/beside.hpp"

namespace shaker::service {

class StateBuilder;

struct BenchServiceSettings {
    bool beside = false;                 // measurements are reduced in a separate thread
    calibration::Estimate mu{NAN, NAN};  // friction coefficient of walker and base; NaN: not known
    std::filesystem::path plans{};       // folder of the plans that clients order by name
    bool fits_mu = true;                 // after each measurement, for clients to see
};

/// Thread safety: all functions on the reduction thread, leave() on any thread. The runner (on call) and the
/// port must outlive this object.
class BenchService {
public:
    /// The runner's options are the first set-point. Identification, mains frequency and the pictures for
    /// which the cameras are opened stay as in the options.
    BenchService(run::Runner& runner, const BenchServiceSettings& settings, BenchPort& bench_port);
    ~BenchService();
    BenchService(const BenchService&) = delete;
    BenchService& operator=(const BenchService&) = delete;

    /// Processes new data, answers at most 16 orders and publishes the state. False when no data arrived.
    bool step(const acquisition::Streams& streams, acquisition::Channels& channels);
    /// Measures a campaign without the order of a client. Before the first step.
    void measure(campaign::PreparedSession prepared) { campaign_.begin(std::move(prepared)); }
    /// Publishes an answer to a request for real time besides those of the runner. Before the first step.
    void publish_grant(acquisition::RealTimeGrant grant) { grants_.push_back(std::move(grant)); }
    /// Requests the end: a soft stop, then recordings are finished, then done(). Orders that start, change or
    /// clear a drive are refused from then on. A further call aborts. Any thread and signal handlers.
    void leave() noexcept {
        if (leaving_.exchange(true)) ++collector_.channels().aborts;
    }
    [[nodiscard]] bool leaving() const noexcept { return leaving_; }
    /// True after leave(), when the drive is silent and all recordings are finished.
    [[nodiscard]] bool done() const noexcept { return done_; }

private:
    using Answers = std::vector<std::pair<Order, std::string>>;  // with the reason of a refusal
    /// The rest of an order whose files are opened, or whose text is read, beside this thread: true when it
    /// is carried out. Throws to refuse it.
    using Rest = std::function<bool(acquisition::Channels&)>;
    void answer(acquisition::Channels& channels);
    std::optional<Order> next_order();
    void go_on(Answers& answers, acquisition::Channels& channels);
    void require_possible(const Order& order) const;
    /// One specialisation for each order, in bench_orders.cpp.
    template <class What>
    void obey(const What& order, acquisition::Channels& channels);
    void begin_run(const run::RunOptions& run, const run::Task& task, const std::filesystem::path& file,
                   const std::optional<run::PredictedWalk>& walk, acquisition::Channels& channels,
                   std::function<void(const std::string& fits)> then);
    void forget_last_run();
    void record(const Record& order, const std::string& stem);
    void take_limits(const safety::Limits& limits, acquisition::Channels& channels);
    void take_outcome();
    void add_row(catalogue::ResultRow row, double ended_s, const std::string& file);
    void compare_points();
    void follow_states();
    void follow_task(acquisition::Channels& channels);
    void follow_to_middle(acquisition::Channels& channels);
    void follow_campaign();
    void predict();
    void go_away(acquisition::Channels& channels);
    void log_finished(const run::FinishedRun& run);
    void log_not_found();
    void log_warnings(const acquisition::Channels& channels);
    void log(const std::string& kind, const std::string& text, std::string key = {});
    void publish();

    // The bench.
    const run::Runner& runner_;
    bench::Bench& bench_;
    acquisition::Collector& collector_;
    BenchPort& bench_port_;
    on_call::OnCall on_call_;
    run::Sequence& sequence_;
    run::Recordings& record_;
    std::unique_ptr<StateBuilder> report_;
    on_call::ToMiddle to_middle_;
    CampaignHost campaign_;

    // Written by orders.
    run::RunOptions run_;                  // a campaign writes its drive, too
    const recorded::KeptPictures opened_;  // pictures for which the cameras were opened
    safety::Limits filed_limits_;          // in the settings files when they were last read
    bool armed_ = false;                   // a set-point was ordered since the last drive
    bool recorded_ = false;                // the next run is recorded
    std::string name_;                     // of the next recording; empty: a name from the time
    std::shared_ptr<const BenchFacts> facts_;
    std::uint64_t answered_ = 0;
    std::uint64_t aborts_seen_ = 0;                // Channels::aborts before the present order was checked
    Rest rest_;                                    // of the order that is obeyed now; empty: none
    std::vector<std::pair<Order, Rest>> waiting_;  // in their order
    std::deque<Order> held_;                       // given after an order that waits
    std::vector<Order> voided_;                    // by an order to stop, which came after them
    std::atomic<bool> leaving_{false};             // by any thread

    // Written by finished measurements.
    std::shared_ptr<const reduction::Reduction> result_;
    law::Friction friction_;        // of result_
    ResultOrigin origin_;           // of result_; its number continues when a new run removes the result
    std::string not_reduced_;       // reason; empty when the newest measurement was reduced
    double measured_from_s_ = NAN;  // master time of the newest measurement, reduced or not
    std::vector<reduction::DrivenPoint> points_;
    std::vector<recording::MeasuredPart> parts_;
    std::optional<reduction::MirrorPair> mirror_;
    std::optional<reduction::NullPhase> null_;
    const bool fits_mu_;
    LiveMu live_mu_;
    calibration::Estimate mu_;  // by an order until measurements give one that they do not contradict
    bool mu_given_ = false;     // by an order
    std::vector<double> closed_form_;

    // Follow from the set-point.
    std::vector<safety::Demand> predicted_;
    std::optional<run::PredictedWalk> walk_;

    // As seen, logged or published at the last step.
    run::RunState state_ = run::RunState::init;  // of the sequence
    run::RunState shown_ = run::RunState::init;
    double finished_s_ = 0;  // master time at which the state finishing ended
    std::shared_ptr<const control::IdentifiedResponse> response_;
    std::size_t logged_notes_ = 0;
    std::array<std::uint64_t, safety::causes> warnings_{};
    std::set<std::string> warned_;        // causes and doubts that were logged in this run
    std::uint64_t not_learned_ = 0;       // count that was logged
    std::vector<std::string> not_found_;  // of each camera, as logged
    double published_s_ = 0, trip_s_ = 0;
    std::string trip_file_;  // see BenchState
    std::vector<PictureState> trip_pictures_;
    std::vector<acquisition::RealTimeGrant> grants_;
    bool done_ = false, changed_ = true;

    Beside disk_;  // the last member: its work ends first
};

}  // namespace shaker::service
