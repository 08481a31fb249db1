#pragma once
// SampleGrid: numbers samples by their stamps and finds how many are missing, also with late stamps.
// Real-time after construction.
#include <array>
#include <boost/circular_buffer.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace shaker::iio {

struct TimedSample {
    std::array<std::int32_t, 3> counts{};
    std::int64_t stamp_ns = 0;    // ns, on the sensor's clock
    std::int64_t arrived_ns = 0;  // ns, arrival at the host
};

struct PlacedSample {
    TimedSample sample;     // with steps of the sensor's clock removed from the stamp
    std::int64_t tick = 0;  // consecutive except for lost samples
    std::int64_t lost = 0;  // number of samples missing just before this one
};

/// Stamps of a steady sensor lie on a line, or later: a delayed interrupt stamps late, and the following ones
/// come in a burst. The line therefore follows the lower edge of the stamps, with a rate measured at the
/// start and tracked from then on. A stamp more than half a step off the line is held back until one of these
/// is certain:
///
/// - a later stamp is on the line: nothing was lost, the stamps were late;
/// - all stamps of 50 ms (and at least 16 samples) stay above the line: the lowest of them shows the number
/// of missing samples. They are missing before the first one held back or, if up to four were merely late,
/// before the first of those that are all higher by a step or more;
/// - they stay more than 20 ms off the line for 0.4 s. If the host also had to wait: that many samples are
/// missing. If not, or if they are below the line: the sensor's clock was set; later stamps are corrected by
/// the step, and samples are lost only as far as the host's time shows.
///
/// The first quarter of a second (32 to 16384 samples) is held back to measure the rate; the nominal rate is
/// used if the result is more than 15 % off. Losses in quick succession are each counted at their place.
class SampleGrid {
public:
    explicit SampleGrid(double rate_hz);

    /// Adds a sample. Empty next() before adding another.
    void add(const TimedSample& sample) noexcept;
    /// Samples whose tick is decided, in order; empty while no tick is decided.
    [[nodiscard]] std::optional<PlacedSample> next() noexcept;

    /// Time between samples on the sensor's clock.
    [[nodiscard]] double step_ns() const noexcept { return step_ns_; }
    /// Number of times the sensor's clock was set.
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
    std::size_t learning_;                        // samples until the rate is measured; 0: done
    static constexpr std::size_t stretches = 16;  // intervals from which the rate is measured
    std::array<double, stretches> lows_{};
    boost::circular_buffer<TimedSample> waiting_;
    boost::circular_buffer<PlacedSample> placed_;
    std::size_t held_ = 0;        // number of waiting samples that are held back
    bool held_above_ = false;     // true: they are above the line
    double held_lowest_ns_ = 0;   // relative to the line
    std::int64_t origin_ns_ = 0;  // origin of the line, for exact doubles
    double due_ns_ = 0;           // expected stamp of the first waiting sample, after the origin
    std::int64_t correction_ns_ = 0;
    std::int64_t tick_ = 0;
    double lowest_ns_ = 0;  // lowest stamp of this window, relative to the line
    int window_ = 0, on_line_ = 0;
    double least_lag_ns_ = 0;
    bool lag_known_ = false;
    std::uint64_t clock_steps_ = 0;
};

}  // namespace shaker::iio
