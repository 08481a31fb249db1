#pragma once
// Walker: exact motion of a walker from event to event. No allocation after construction.
#include <array>
#include <cstdint>
#include <span>

#include "drivers/walker/walker_law.hpp"

namespace shaker::walker {

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

/// Advances a walker by whole periods or to any phase. Phases stay within a period, so the millionth period
/// is as exact as the first. Evaluating an intermediate point does not change the path. Keeps a reference to
/// its law, which must outlive it.
class Walker {
public:
    /// Starts in period 0 at `phase` (t/T, 0 <= phase < 1) with velocity v (m/s).
    explicit Walker(const WalkerLaw& law, double v = 0, double phase = 0);

    /// Advances to the next start of a period. Returns the distance (m) walked in the period that ends there;
    /// if the walker entered that period at its start, this is D.
    double advance_period() noexcept;
    /// Advances to `phase` (t/T, 0..1) of the current period. Throws std::invalid_argument for a past phase.
    WalkerPoint advance_to(double phase);

    /// The present position.
    [[nodiscard]] WalkerPoint now() const noexcept { return now_; }
    /// Number of completed periods.
    [[nodiscard]] std::int64_t period() const noexcept { return period_; }
    /// Events so far of the period of the last advance; valid until the next advance.
    [[nodiscard]] std::span<const WalkerEvent> events() const noexcept {
        return {events_.data(), event_count_};
    }

private:
    // Each direction has at most 17 falling pieces per period, with one end of slip each, and at most 32
    // releases of stick: 66 events.
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
    // The present segment: contact and motion at its start, and the event that ends it.
    Contact contact_ = Contact::stick;
    double from_ = 0;         // rad
    Motion motion_;           // at from_; x counts from the start of the period
    double x_base_from_ = 0;  // stick only
    SlipLaw::Zero end_;       // phase is SlipLaw::never when the period ends first
    WalkerPoint now_;
    double now_phase_ = 0;  // rad
    double x_before_ = 0;   // m, of the completed periods
    std::int64_t period_ = 0;
    bool fresh_ = true;  // events_ belongs to the previous period
    std::size_t event_count_ = 0;
    std::array<WalkerEvent, most_events> events_{};
};

}  // namespace shaker::walker
