#pragma once
// A bench on call: idle until it is ordered to drive, for weeks. Leads the director, keeps the orders'
// conditions, has measurements reduced and recorded, and publishes what the bench is at.
#include <atomic>
#include <cmath>
#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "daemon/desk.hpp"
#include "daemon/run_record.hpp"

namespace shaker {

class StateReport;

/// The limits of a bench on call: the DAC may run empty, the drive comes up softly again by itself some
/// times.
Limits limits_on_call(Limits limits);

struct SessionSettings {
    RunOptions run;  // what is wanted at first; identify, mains, pictures for good
    RunRecordSettings record;
    bool beside = false;    // measurements are reduced in a thread beside this one
    Estimate mu{NAN, NAN};  // of walker and base, where it is known
};

/// All of it on the reduction's thread. The desk, the bench and the acquisition outlive this.
class Session {
public:
    Session(OpenRig& bench, Acquisition& acquisition, const SessionSettings& settings, Desk& desk);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// After new data: answers orders, goes on, publishes. False when nothing had come.
    bool step(const Take& take, Lanes& lanes);
    /// To be over as soon as the drive has come down softly and what is recorded is finished. Any thread.
    void leave() noexcept { leaving_ = true; }
    [[nodiscard]] bool leaving() const noexcept { return leaving_; }
    /// It has left.
    [[nodiscard]] bool done() const noexcept { return done_; }
    /// The recorder's thread.
    bool record() { return record_.step(); }
    [[nodiscard]] const Director& director() const noexcept { return director_; }

private:
    /// A reduction, or why there is none.
    using Outcome = std::variant<std::shared_ptr<const Reduction>, std::string>;

    bool answer(Lanes& lanes);
    void obey(const SetDrive& order, Lanes& lanes);
    void obey(const Begin& order, Lanes& lanes);
    void obey(const Identify& order, Lanes& lanes);
    void obey(const End& order, Lanes& lanes);
    void obey(const ClearTrip& order, Lanes& lanes);
    void obey(const Record& order, Lanes& lanes);
    void obey(const Remark& order, Lanes& lanes);
    void obey(const CloseLoop& order, Lanes& lanes);
    void obey(const LowerLimits& order, Lanes& lanes);
    void obey(const Adopt& order, Lanes& lanes);
    void require_possible(const Drive& drive, const Limits& limits) const;
    void take_limits(const Limits& limits, Lanes& lanes);
    void measure(const Take& take);
    void take_outcome();
    void compare_points();
    void follow_states();
    void go_away(Lanes& lanes);
    void tidy(Take& take) const;
    void tell(std::string kind, const std::string& text);
    void publish();

    OpenRig& bench_;
    Acquisition& acquisition_;
    RunOptions run_;
    KeptPictures opened_;  // what the cameras were opened for
    bool beside_;
    Desk& desk_;
    Limits limits_;
    Director director_;
    RunRecord record_;
    std::unique_ptr<StateReport> report_;
    bool armed_ = false;     // a drive was asked for since nothing was driven last
    bool recorded_ = false;  // the next run is
    std::string name_;       // of that recording; empty: by the time
    std::uint64_t answered_ = 0;
    RunState state_ = RunState::init;
    bool active_ = false, stop_told_ = false;  // a run that is not finished; why it was stopped was recorded
    std::size_t measured_ = 0, told_notes_ = 0;
    std::uint64_t not_learned_ = 0;  // that was told
    struct Pending {
        Drive asked;
        MeasuredPart part;
        std::future<Outcome> outcome;
    };
    std::deque<Pending> pending_;
    std::shared_ptr<const Reduction> result_;
    std::string not_reduced_;
    double measured_from_s_ = NAN;  // of what is either
    std::shared_ptr<const BenchFacts> facts_;
    std::vector<DrivenPoint> points_;
    std::vector<MeasuredPart> parts_;
    std::optional<MirrorPair> mirror_;
    std::optional<NullPhase> null_;
    std::vector<double> closed_form_;
    Estimate mu_;
    std::vector<Demand> predicted_;
    std::shared_ptr<const IdentifiedResponse> response_;
    std::atomic<bool> leaving_{false};
    bool done_ = false, changed_ = true;
    double published_s_ = 0, trip_s_ = 0;
};

}  // namespace shaker
