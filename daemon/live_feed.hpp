#pragma once
// The newest seconds of what is measured, for eyes: the session adds, any number of viewers read from where
// they were.
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

namespace shaker {

/// Evenly spaced samples of up to four channels.
class LiveSeries {
public:
    LiveSeries(std::size_t channels, std::size_t most) : channels_{channels}, most_{most} {}
    /// One value a channel, at a master time, s. What is older than `most` samples is forgotten.
    void add(double t_s, std::span<const float> values);

    struct Part {
        std::uint64_t first = 0;  // number of its first sample, from the start
        std::vector<double> t_s;
        std::vector<float> values;  // a row of channels a sample
        bool gap = false;           // samples before it were forgotten unread
    };
    /// What came from sample `from` on; any thread.
    [[nodiscard]] Part since(std::uint64_t from) const;
    [[nodiscard]] std::size_t channels() const noexcept { return channels_; }

private:
    std::size_t channels_, most_;
    mutable std::mutex mutex_;
    std::uint64_t count_ = 0;  // samples so far; sample k is at k % most_
    std::vector<double> t_s_;
    std::vector<float> values_;
};

struct LiveFeed {
    LiveSeries acceleration{2, 65536};  // of the base along the axis, m/s^2: asked, measured
    LiveSeries track{2, 16384};         // walker, base, m
};

}  // namespace shaker
