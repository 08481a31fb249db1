#include "calibration/clocks/clock_tracker.hpp"

#include <algorithm>

namespace shaker::calibration {
namespace {

// 20 s of blocks of 64 samples at 48 kHz. At higher rates of stamps the window is shorter.
constexpr std::size_t most_stamps = 16384;
constexpr std::int64_t refit_ns = 500'000'000;
constexpr double ns_to_know_rate = 2e9;
constexpr std::size_t parts = 16;  // of the window

// Assumptions before the first fit of the rate: crystals within 100 ppm, delays that vary by a millisecond.
constexpr double first_rate_sigma = 100e-6;
constexpr double first_scatter_ns = 1e6;
// Largest drift of a crystal's rate while it warms up: 1 ppm per minute.
constexpr double wander_per_ns = 1e-6 / 60e9;

}  // namespace

LineUnderStamps::LineUnderStamps(double ns_per_tick, std::int64_t window_ns)
    : nominal_ns_{ns_per_tick},
      window_ns_{window_ns},
      stamps_(most_stamps),
      excess_rate_sigma_{first_rate_sigma},
      scatter_ns_{first_scatter_ns} {
    hull_.reserve(most_stamps);
}

void LineUnderStamps::add(std::int64_t tick, std::int64_t ns) noexcept {
    if (size_ > 0 && tick <= stamp(size_ - 1).tick) return;
    while (size_ > 0 && (size_ == most_stamps || stamp(0).ns < ns - window_ns_)) {
        oldest_ = (oldest_ + 1) % most_stamps;
        --size_;
    }
    stamps_[(oldest_ + size_) % most_stamps] = {tick, ns};
    ++size_;
    if (!line_ || ns - fitted_ns_ >= refit_ns) {
        fitted_ns_ = ns;
        fit();
    }
}

void LineUnderStamps::restart() noexcept {
    size_ = 0;
    line_.reset();
}

const LineUnderStamps::Stamp& LineUnderStamps::stamp(std::size_t i) const noexcept {
    return stamps_[(oldest_ + i) % most_stamps];
}

LineUnderStamps::Vertex LineUnderStamps::point(std::size_t i) const noexcept {
    const double x = static_cast<double>(stamp(i).tick - stamp(0).tick);
    return {x, static_cast<double>(stamp(i).ns - stamp(0).ns) - nominal_ns_ * x};
}

LineUnderStamps::Vertex LineUnderStamps::mean() const noexcept {
    Vertex sum{0, 0};
    for (std::size_t i = 0; i < size_; ++i) {
        const Vertex p = point(i);
        sum.x += p.x;
        sum.y += p.y;
    }
    return {sum.x / static_cast<double>(size_), sum.y / static_cast<double>(size_)};
}

void LineUnderStamps::fit() noexcept {
    const double span_ns = nominal_ns_ * static_cast<double>(stamp(size_ - 1).tick - stamp(0).tick);
    if (span_ns >= ns_to_know_rate)
        follow_hull(mean());
    else
        follow_known_rate(mean());
}

/// Andrew's monotone chain; the ticks are already sorted.
void LineUnderStamps::build_hull() noexcept {
    hull_.clear();
    for (std::size_t i = 0; i < size_; ++i) {
        const Vertex p = point(i);
        while (hull_.size() >= 2) {
            const Vertex a = hull_[hull_.size() - 2];
            const Vertex b = hull_.back();
            if ((b.x - a.x) * (p.y - a.y) > (b.y - a.y) * (p.x - a.x)) break;
            hull_.pop_back();
        }
        hull_.push_back(p);
    }
}

void LineUnderStamps::follow_hull(Vertex mean) noexcept {
    build_hull();
    const auto after = std::upper_bound(hull_.begin() + 1, hull_.end() - 1, mean.x,
                                        [](double x, const Vertex& v) { return x < v.x; });
    const Vertex b = *after;
    const Vertex a = *(after - 1);
    excess_rate_ = (b.y - a.y) / (b.x - a.x);
    const double y = a.y + excess_rate_ * (mean.x - a.x);
    // With correlated delays, the lowest stamps of some parts of the window lie far above the line, and their
    // mean height determines the scatter. With independent delays both values agree.
    scatter_ns_ = std::max(mean.y - y, lowest_of_parts(mean, y) * static_cast<double>(size_) / parts);
    set_line(mean, y, excess_rate_, scatter_ns_, 0);
    excess_rate_sigma_ = line_->sigma_rate;
}

double LineUnderStamps::lowest_of_parts(Vertex mean, double y) const noexcept {
    double sum = 0;
    for (std::size_t k = 0; k < parts; ++k) {
        double lowest = INFINITY;
        for (std::size_t i = k * size_ / parts; i < (k + 1) * size_ / parts; ++i) {
            const Vertex p = point(i);
            lowest = std::min(lowest, p.y - y - excess_rate_ * (p.x - mean.x));
        }
        sum += std::isfinite(lowest) ? lowest : 0;
    }
    return sum / parts;
}

void LineUnderStamps::follow_known_rate(Vertex mean) noexcept {
    double y = point(0).y;
    for (std::size_t i = 0; i < size_; ++i) {
        const Vertex p = point(i);
        y = std::min(y, p.y - excess_rate_ * p.x);
    }
    set_line(mean, y + excess_rate_ * mean.x, excess_rate_, scatter_ns_, excess_rate_sigma_);
}

void LineUnderStamps::set_line(Vertex mean, double y, double excess_rate, double scatter_ns,
                               double known_rate_sigma) noexcept {
    // For n exponentially distributed delays, mean and standard deviation of the line's error are 2 scatter /
    // n.
    const double quarter_ns = 0.25 * nominal_ns_ * static_cast<double>(stamp(size_ - 1).tick - stamp(0).tick);
    const double offset_ns = 2 * scatter_ns / static_cast<double>(size_);
    const double bend_ns = 0.5 * wander_per_ns * quarter_ns * quarter_ns;
    const double tilt_ns = known_rate_sigma * quarter_ns;
    const double rate = known_rate_sigma > 0 ? known_rate_sigma
                                             : std::hypot(offset_ns / quarter_ns, wander_per_ns * quarter_ns);
    // The line is given at the whole tick nearest to the mean.
    const double x = std::round(mean.x);
    const double ns = nominal_ns_ * x + y + excess_rate * (x - mean.x);
    line_ = Line{stamp(0).tick + static_cast<std::int64_t>(x),
                 stamp(0).ns + std::llround(ns),
                 nominal_ns_ + excess_rate,
                 std::max(mean.y - y, 0.0),
                 std::hypot(offset_ns, bend_ns, tilt_ns),
                 rate};
}

}  // namespace shaker::calibration
