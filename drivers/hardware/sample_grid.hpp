#pragma once
// Numbers samples by their stamps: finds how many are missing, however unpunctual the stamps. Real-time once
// built.
#include <array>
#include <boost/circular_buffer.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace shaker {

struct TimedSample {
    std::array<std::int32_t, 3> counts{};
    std::int64_t stamp_ns = 0;    // on the sensor's clock
    std::int64_t arrived_ns = 0;  // when the host got it
};

struct PlacedSample {
    TimedSample sample;     // steps of the sensor's clock taken out of the stamp
    std::int64_t tick = 0;  // consecutive but for the lost ones
    std::int64_t lost = 0;  // samples missing just before this one
};

/// Stamps of a steady sensor lie on a line, or later: an interrupt that had to wait is stamped late, and
/// those after it in a burst. So the line is followed along the lower edge of the stamps, at a rate that is
/// measured at the start and tracked from then on. A stamp more than half a step off the line is held back
/// until one of these is clear:
///
/// - a later stamp is on the line: nothing was lost, the stamps were late;
/// - all stamps of 50 ms (and of at least 16 samples) stay above the line: as many samples are missing as the
///   lowest of them is above it, before the first held back, or before the first of those that are all higher
///   by a step or more, where up to four in front of them were only late;
/// - they stay more than 20 ms off the line for 0.4 s: that many are missing, if the host had to wait for
/// them;
///   if not, or if they are below the line, the sensor's clock was set. Stamps are corrected by the step from
///   then on, and samples are lost only as far as the host's own time tells.
///
/// The first quarter second (32 to 16384 samples) is held back to measure the rate; the nominal one counts
/// where that comes out more than 15 % off. Losses close upon one another are each counted at their place.
class SampleGrid {
public:
    explicit SampleGrid(double rate_hz);

    /// The next sample. Take what next() has before giving another.
    void add(const TimedSample& sample) noexcept;
    /// Samples whose tick is decided, in order; empty when there are none (yet).
    [[nodiscard]] std::optional<PlacedSample> next() noexcept;

    /// Time between samples on the sensor's clock.
    [[nodiscard]] double step_ns() const noexcept { return step_ns_; }
    /// How often the sensor's clock was set.
    [[nodiscard]] std::uint64_t clock_steps() const noexcept { return clock_steps_; }

private:
    [[nodiscard]] double above_line(std::size_t i) const noexcept;
    [[nodiscard]] double lag_ns(std::size_t i) const noexcept;
    void learn_rate() noexcept;
    void settle() noexcept;
    [[nodiscard]] bool clear() const noexcept;
    [[nodiscard]] std::size_t late_before_loss() const noexcept;
    void decide() noexcept;
    [[nodiscard]] std::int64_t follow_clock(double lag_change_ns) noexcept;
    void place_first(std::int64_t lost) noexcept;
    void follow(double above_ns, double lag_ns) noexcept;

    double nominal_ns_, step_ns_;
    std::size_t learning_;  // samples still to come before the rate is measured; 0: it is
    static constexpr std::size_t stretches = 16;  // of what the rate is measured from
    std::array<double, stretches> lows_{};
    boost::circular_buffer<TimedSample> waiting_;
    boost::circular_buffer<PlacedSample> placed_;
    std::size_t held_ = 0;        // of the waiting ones, looked at and not clear
    bool held_above_ = false;     // on which side of the line they are
    double held_lowest_ns_ = 0;   // against the line
    std::int64_t origin_ns_ = 0;  // of the line's times, so that they are exact as doubles
    double due_ns_ = 0;           // when the first waiting sample should be stamped, after the origin
    std::int64_t correction_ns_ = 0;
    std::int64_t tick_ = 0;
    double lowest_ns_ = 0;  // of this window's stamps, against the line
    int window_ = 0, on_line_ = 0;
    double least_lag_ns_ = 0;
    bool lag_known_ = false;
    std::uint64_t clock_steps_ = 0;
};

}  // namespace shaker
