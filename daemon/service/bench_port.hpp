#pragma once
// Between the bench's session and those who look at it and order from outside: the only way in and out.
// Neither side waits for the other.
#include <atomic>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "daemon/service/bench_state.hpp"
#include "daemon/service/live_feed.hpp"

namespace shaker::service {

/// What may be ordered. Each is done or refused as a whole.
struct SetDrive {
    Drive drive;
};
struct Begin {
    int periods;
    int settle = 0;  // periods of the settled drive before them; 0: until the walker is steady
};
struct Identify {};
struct End {};
struct ClearTrip {};
struct Record {
    bool on;
    std::string name;  // without folder or ending; empty: by the time
    recorded::KeptPictures pictures;
};
struct LowerLimits {
    safety::Limits limits;  // none above those in force
};
/// Of the operator, for the log and the recording: the one that grows, else the next.
struct Remark {
    static constexpr std::size_t longest = 400;  // bytes
    std::string text;
};
/// Whether measured harmonics correct the drive, in the runs that follow.
struct CloseLoop {
    bool on;
};
/// From the settings files only, never from a network.
struct Adopt {
    Drive drive;
    int periods, settle;
    safety::Limits limits;  // may be above those in force
};
using OrderWhat =
    std::variant<SetDrive, Begin, Identify, End, ClearTrip, Record, Remark, CloseLoop, LowerLimits, Adopt>;

struct Order {
    OrderWhat what;
    /// Called once by the session's thread with why it was refused; empty: it was done.
    std::function<void(const std::string& refused)> answer;
};

/// A line of the log for everybody.
struct BenchEvent {
    std::uint64_t number = 0;  // counts from 1
    double t_s = 0;            // master time
    std::string kind;          // "state", "note", "trip", "order"
    std::string text;
};

class BenchPort {
public:
    static constexpr std::size_t most_orders = 256;  // that wait
    static constexpr std::size_t most_events = 200;  // that are kept

    // For any thread.
    /// Stops the drive at once, whatever else waits; by: who asked, for the log.
    void abort(const std::string& by);
    /// How often abort() was called: what BenchState::aborts comes to.
    [[nodiscard]] std::uint64_t aborted() const noexcept { return aborted_; }
    /// Never waits; an order beyond what may wait is refused at once.
    void order(Order order);
    /// Orders given so far, refused ones too: what BenchState::answered comes to.
    [[nodiscard]] std::uint64_t ordered() const;
    /// Null before the first.
    [[nodiscard]] std::shared_ptr<const BenchState> state() const;
    /// Those after number `seen`, oldest first.
    [[nodiscard]] std::vector<BenchEvent> events(std::uint64_t seen) const;
    [[nodiscard]] LiveFeed& feed() noexcept { return feed_; }

    // For the session's thread.
    /// How abort() reaches the output. Before anybody else knows of the desk.
    void stop_by(std::function<void()> stop) { stop_ = std::move(stop); }
    [[nodiscard]] std::optional<Order> next();
    void publish(std::shared_ptr<const BenchState> state);
    void tell(double t_s, std::string kind, std::string text);

private:
    mutable std::mutex mutex_;
    std::atomic<std::uint64_t> aborted_{0};
    std::function<void()> stop_;
    std::deque<Order> orders_;
    std::uint64_t ordered_ = 0;
    std::shared_ptr<const BenchState> state_;
    std::deque<BenchEvent> events_;
    std::uint64_t told_ = 0;
    LiveFeed feed_;
};

}  // namespace shaker::service
