#pragma once
// A walker under way: from event to event, exactly. Nothing allocates after construction.
#include <array>
#include <cstdint>
#include <span>

#include "drivers/simulated/walker_law.hpp"

namespace shaker {

/// A change of contact.
struct WalkerEvent {
    double phase = 0;  // t/T, 0..1
    Contact from = Contact::stick;
    Contact to = Contact::stick;
};

struct WalkerPoint {
    double x = 0;  // m from where the walker started
    double v = 0;  // m/s
    Contact contact = Contact::stick;
};

/// Steps a walker over whole periods or to any instant. Phases stay within the period, so the millionth
/// period is as exact as the first. Looking at a point in between does not change the path by a bit. Keeps a
/// reference to its law.
class Walker {
public:
    /// Starts in period 0 at `phase` (t/T, 0 <= phase < 1) with velocity v (m/s).
    explicit Walker(const WalkerLaw& law, double v = 0, double phase = 0);

    /// On to the next start of a period. Returns the distance (m) walked in the period that ends there: D,
    /// when it was entered at its start.
    double advance_period() noexcept;
    /// On to `phase` (t/T, 0..1) of the current period. Throws std::invalid_argument for an instant that is
    /// past.
    WalkerPoint advance_to(double phase);

    /// Where it is now.
    [[nodiscard]] WalkerPoint now() const noexcept { return now_; }
    /// Periods completed.
    [[nodiscard]] std::int64_t period() const noexcept { return period_; }
    /// Events of the period last advanced in, so far; valid until the next advance.
    [[nodiscard]] std::span<const WalkerEvent> events() const noexcept {
        return {events_.data(), event_count_};
    }

private:
    // Each direction has at most 17 falling pieces a period, which hold one end of slip each, and at most 32
    // zones of stick release: 66 events.
    static constexpr std::size_t most_events = 80;

    void begin_stick(double phase, double x_base) noexcept;
    void begin_slip(Contact direction, double phase, double C, double ignore_until) noexcept;
    void take_event() noexcept;
    void release() noexcept;
    void end_slip() noexcept;
    void record(Contact from, Contact to) noexcept;
    void forget_last_period() noexcept;
    [[nodiscard]] Motion motion_at(double phase) const noexcept;

    const WalkerLaw* law_;
    // The segment under way: contact and motion at its start, and where the next event ends it.
    Contact contact_ = Contact::stick;
    double from_ = 0;         // rad
    Motion motion_;           // at from_; x is counted from the start of the period
    double x_base_from_ = 0;  // stick only
    SlipLaw::Zero end_;       // phase is SlipLaw::never when the period ends first
    WalkerPoint now_;
    double now_phase_ = 0;  // rad
    double x_before_ = 0;   // of the periods completed, m
    std::int64_t period_ = 0;
    bool fresh_ = true;  // events_ is of the period before
    std::size_t event_count_ = 0;
    std::array<WalkerEvent, most_events> events_{};
};

}  // namespace shaker
