#pragma once
// The newest seconds of measured signals for display. The service adds samples; any number of viewers read,
// each from its own position.
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

namespace shaker::service {

/// Evenly spaced samples of up to four channels.
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

struct LiveFeed {
    LiveSeries acceleration{2, 65536};  // base along the axis, m/s^2: target, measured
    LiveSeries track{2, 16384};         // x of walker and base, m
};

}  // namespace shaker::service
