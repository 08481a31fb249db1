#pragma once
// A base that follows the voltage without delay, its two devices, and the loops of output and accelerometer.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "daemon/acquisition/drive_output.hpp"
#include "daemon/acquisition/steps.hpp"

namespace shaker::test {

using safety::Cause;
using safety::Limits;
using safety::SampleGuard;
using safety::Trip;

inline constexpr double rate = 48000;
inline constexpr std::int64_t block = 240;
inline constexpr std::size_t most_blocks = 4000;

/// State shared by the two devices.
struct Base {
    double gain = 20;  // m/s^2 a volt
    bool unplugged = false;
    bool reads_early = false;  // as a sensor whose samples wait for their place in time
    bool held_back = false;    // they wait
    std::vector<std::array<std::int32_t, 3>> early;
    std::function<void()> meanwhile;  // what happens once while a block is written
    std::int64_t empty = 0;           // duration of an underrun that the next write reports, samples
    std::vector<double> played;
    std::deque<AccelBlock> ready;
    AccelBlock filling{.first = {0}, .arrived = {}, .size = 0};

    void sample(double volts) {
        const int n = static_cast<int>(filling.first.n) + filling.size;
        filling.counts[static_cast<std::size_t>(filling.size++)] = {
            static_cast<std::int32_t>(1000 * gain * volts) + n % 2, n % 3, 9800};
        if (reads_early && !unplugged)
            early.push_back(filling.counts[static_cast<std::size_t>(filling.size - 1)]);
        if (filling.size < AccelBlock::capacity) return;
        if (!unplugged) ready.push_back(filling);
        filling.first.n += filling.size;
        filling.size = 0;
    }
};

class BaseDac final : public Dac {
public:
    explicit BaseDac(Base& base) : base_{base} { base_.played.reserve(most_blocks * block); }
    [[nodiscard]] DacInfo info() const override {
        return {.name = "bench", .rate_hz = rate, .full_scale_V = 1};
    }
    PlayTime write(std::span<const double> volts, std::span<const double>) override {
        if (const auto happens = std::exchange(base_.meanwhile, nullptr)) happens();
        const PlayTime now{{std::ssize(base_.played)}, {}, std::exchange(base_.empty, 0)};
        for (const double v : volts) {
            if (std::ssize(base_.played) % 12 == 0) base_.sample(v);
            base_.played.push_back(v);
        }
        for (std::int64_t i = 0; i < now.lost; ++i) {
            if (std::ssize(base_.played) % 12 == 0) base_.sample(0);
            base_.played.push_back(0);
        }
        return now;
    }
    void stop() noexcept override {}

private:
    Base& base_;
};

class BaseAccelerometer final : public Accelerometer {
public:
    explicit BaseAccelerometer(Base& base) : base_{base} {}
    [[nodiscard]] AccelerometerInfo info() const override {
        return {.name = "bench", .mps2_per_count = {1e-3, 1e-3, 1e-3}, .shaker_axis = {1, 0, 0}};
    }
    bool read(AccelBlock& out, std::chrono::milliseconds) override {
        if (base_.ready.empty() || base_.held_back) return false;
        out = base_.ready.front();
        base_.ready.pop_front();
        return true;
    }
    std::size_t read_early(std::span<std::array<std::int32_t, 3>> counts) noexcept override {
        const std::size_t n = std::min(counts.size(), base_.early.size());
        std::copy_n(base_.early.begin(), n, counts.begin());
        base_.early.erase(base_.early.begin(), base_.early.begin() + static_cast<std::ptrdiff_t>(n));
        return n;
    }
    [[nodiscard]] bool ended() const noexcept override { return false; }
    void stop() noexcept override {}

private:
    Base& base_;
};

inline Limits limits() {
    Limits l;
    l.acceleration = {12, 15};
    l.drive = {0.8, 1};
    return l;
}

inline Limits without(Cause cause) {
    Limits l = limits();
    l.detectors.reset(static_cast<std::size_t>(cause));
    return l;
}

inline DriveCommand volts(double v) {
    DriveCommand c;
    c.volts.at(1) = v;
    return c;
}

struct Guarded {
    explicit Guarded(const Limits& l)
        : output{dac.info(), 20, 0, block, l, 4000}, input{SampleGuard{accelerometer.info(), rate, l}} {}
    /// Output, accelerometer, reduction: as the lockstep executor calls them.
    void go(double s) {
        for (const auto end = std::ssize(base.played) + std::llround(s * rate);
             std::ssize(base.played) < end;) {
            output_step(output, dac, channels);
            while (accelerometer_step(input, accelerometer, {}, channels)) read_at = std::ssize(base.played);
            if (reduction_lives) channels.gathered = std::ssize(base.played);
            while (channels.blocks.pop()) {
            }
            while (channels.played.pop()) {
            }
            while (const auto c = channels.changes.pop())
                if (c->stop > 0 && !stop) stop = *c;
            while (const auto t = channels.trips.pop()) trips.push_back(*t);
        }
    }
    /// First sample from which the drive is zero.
    [[nodiscard]] std::int64_t zero_from() const {
        auto n = std::ssize(base.played);
        while (n > 0 && base.played[static_cast<std::size_t>(n - 1)] == 0) --n;
        return n;
    }
    void start(double v) {
        trips.reserve(16);
        channels.drive.post(volts(v));
        go(1);
        EXPECT_TRUE(trips.empty()) << text(trips.at(0));
        EXPECT_GT(zero_from(), std::ssize(base.played) - 10) << "driven";
    }
    Base base;
    BaseDac dac{base};
    BaseAccelerometer accelerometer{base};
    acquisition::Channels channels{0};
    acquisition::DriveOutput output;
    acquisition::AccelerometerInput input;
    bool reduction_lives = true;
    std::int64_t read_at = 0;  // samples played when the last block was read
    std::vector<Trip> trips;
    std::optional<DriveChange> stop;
};

}  // namespace shaker::test
