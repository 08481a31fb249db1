#pragma once
// The only connection between the bench service and its clients: orders in, state and events out.
// Neither side waits for the other.
#include <atomic>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "daemon/acquisition/moved_targets.hpp"
#include "daemon/campaign/engine.hpp"
#include "daemon/catalogue/results_table.hpp"
#include "daemon/service/bench_state.hpp"
#include "daemon/service/event_log.hpp"

namespace shaker::service {

/// Evenly spaced samples of up to four channels, for display. The service adds samples; any number of viewers
/// read, each from its own position.
class LiveSeries {
public:
    LiveSeries(std::size_t channels, std::size_t most) : channels_{channels}, most_{most} {}
    /// Adds one value per channel at master time t_s (s). Only the newest `most` samples are kept.
    void add(double t_s, std::span<const float> values);

    struct Part {
        std::uint64_t first = 0;  // number of its first sample since the start
        std::vector<double> t_s;
        std::vector<float> values;  // one row of channels per sample
        bool gap = false;           // samples before it were dropped unread
    };
    /// The samples from number `from` on. Any thread.
    [[nodiscard]] Part since(std::uint64_t from) const;
    [[nodiscard]] std::size_t channels() const noexcept { return channels_; }

private:
    std::size_t channels_, most_;
    mutable std::mutex mutex_;
    std::uint64_t count_ = 0;  // samples since the start; sample k is at k % most_
    std::vector<double> t_s_;
    std::vector<float> values_;
};

/// The newest seconds of measured signals.
struct LiveFeed {
    LiveSeries acceleration{2, 65536};  // base along the axis, m/s^2: target, measured
    LiveSeries track{2, 16384};         // x of walker and base, m
};

// The orders. Each one is carried out or refused as a whole.

/// A new set-point.
struct SetDrive {
    Drive drive;
};
/// Starts a run. drive: also a new set-point, which is not set when the run is refused.
struct Begin {
    MeasurementPlan plan;
    std::optional<Drive> drive{};
};
/// Identifies the response, then silence.
struct Identify {};
/// From rest: leads the walker to the middle of the picture, then silence. The set-point stays.
struct BringToMiddle {};
/// At rest, on a simulated bench: puts the walker back to the middle of its base.
struct PutWalkerBack {};
/// From rest: measures the points of a plan into a folder of its own.
struct MeasurePlan {
    std::string name;    // of the plan, without folder or ending
    std::string text{};  // TOML; empty: the plan of that name in the folder of the plans
};
/// Checks a plan: how long it takes, and which points do not fit the view. Nothing moves.
struct CheckPlan {
    std::string name;  // as in MeasurePlan
    std::string text{};
};
/// A word to the campaign under way.
struct TellCampaign {
    campaign::Word word;
};
/// Soft stop. Pauses a campaign.
struct End {};
/// Clears the trips that the client has been shown. A trip that came later refuses it.
struct ClearTrip {
    /// BenchState::trips shown to the client, at most those published when the order is given.
    std::uint64_t shown = std::numeric_limits<std::uint64_t>::max();
};
/// Switches recording of the following runs.
struct Record {
    bool on;
    std::string name;  // without folder or ending; empty: a name from the time
    recorded::KeptPictures pictures;
};
/// Lowers one limit. The others stay, also those that changed since the client gave the order.
struct LowerLimit {
    safety::LimitKey key;
    double value;  // see safety::lower()
};
/// Operator's remark for the log and for the open recording, or the next one when no recording is open.
struct Remark {
    static constexpr std::size_t longest = 400;  // bytes
    std::string text;
};
/// Switches the correction of the drive by measured harmonics in the following runs.
struct CloseLoop {
    bool on;
};
/// The friction coefficient of walker and base, by which walks are predicted until measurements give one.
struct GiveMu {
    calibration::Estimate mu;
};
/// At rest: new regions of targets, which are learned in them. They last until the daemon ends.
struct MoveTargets {
    std::vector<acquisition::MovedTarget> targets;
};
/// New settings from the settings files; no network client can give this order.
struct Adopt {
    Drive drive;
    MeasurementPlan plan;
    safety::Limits limits;         // may be above the present limits
    bool restores_limits = false;  // false: a limit that is as in the files before keeps its present value
};
using OrderWhat = std::variant<SetDrive, Begin, Identify, BringToMiddle, PutWalkerBack, MeasurePlan,
                               CheckPlan, TellCampaign, End, ClearTrip, Record, Remark, CloseLoop, LowerLimit,
                               GiveMu, MoveTargets, Adopt>;

struct Order {
    OrderWhat what;
    /// Called once on the service's thread with the reason of a refusal; empty: the order was carried out.
    std::function<void(const std::string& refused)> answer;
    std::uint64_t aborts = 0;  // set by BenchPort::order(): aborts before this order
};

class BenchPort {
public:
    static constexpr std::size_t most_orders = 256;  // waiting orders

    // Any thread:

    /// Stops the drive at once, before all waiting orders. by: name of the client, for the log. Returns the
    /// number of this abort, for obeyed().
    std::uint64_t abort(const std::string& by);
    /// Number of the newest abort that the output has obeyed: it ramps to zero, or it was silent and latched.
    [[nodiscard]] std::uint64_t obeyed() const { return obeyed_(); }
    /// Calls of abort(). BenchState::aborts reaches this number when the bench has carried them out.
    [[nodiscard]] std::uint64_t aborted() const noexcept { return aborted_; }
    /// False while the shaker may be driven, or an order or a campaign may drive it soon. Needs no lock.
    [[nodiscard]] bool at_rest() const noexcept { return at_rest_; }
    /// Never waits. An order that can drive the shaker is refused if an abort comes before it is carried out.
    /// An order that finds most_orders waiting orders is refused at once.
    void order(Order order);
    /// Accepted orders. BenchState::answered reaches this number when all of them are answered.
    [[nodiscard]] std::uint64_t ordered() const;
    /// The newest state; null before the first.
    [[nodiscard]] std::shared_ptr<const BenchState> state() const;
    /// Remembered events with a number above `seen`, in order of their numbers.
    [[nodiscard]] std::vector<BenchEvent> events(std::uint64_t seen) const;
    [[nodiscard]] LiveFeed& feed() noexcept { return feed_; }
    /// The newest measurements, also of recordings of before.
    [[nodiscard]] catalogue::ResultsTable& results() noexcept { return results_; }

    // The service's thread:

    /// Sets the function by which abort() stops the output, which returns the number of the abort, and the
    /// function that returns the newest number obeyed. Any thread calls them. Call it before any client uses
    /// the port.
    void stop_by(std::function<std::uint64_t()> stop, std::function<std::uint64_t()> obeyed) {
        stop_ = std::move(stop);
        obeyed_ = std::move(obeyed);
    }
    [[nodiscard]] std::optional<Order> next();
    void publish(std::shared_ptr<const BenchState> state);
    /// Adds an event; see EventLog::add(). Any thread.
    void log(double t_s, const std::string& kind, std::string text, std::string key = {});

private:
    mutable std::mutex mutex_;
    std::atomic<std::uint64_t> aborted_{0};
    std::atomic<bool> at_rest_{true};
    std::function<std::uint64_t()> stop_, obeyed_;
    std::deque<Order> orders_;
    std::uint64_t ordered_ = 0;
    std::shared_ptr<const BenchState> state_;
    EventLog events_;
    LiveFeed feed_;
    catalogue::ResultsTable results_;
};

}  // namespace shaker::service
