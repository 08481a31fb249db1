#include "calibration/clocks/clock_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "tests/support/no_alloc.hpp"

namespace shaker::calibration {
namespace {

using std::chrono::nanoseconds;

constexpr double rate = 48000;
constexpr std::int64_t block = 256;

/// A device with its own clock, whose blocks are stamped late.
class Device {
public:
    Device(double ppm, std::function<double(std::mt19937_64&)> delay_s, unsigned seed,
           double ppm_a_minute = 0)
        : ppm_{ppm}, ppm_a_minute_{ppm_a_minute}, delay_s_{std::move(delay_s)}, random_{seed} {}

    /// True time of a tick. The host has been running for a year.
    [[nodiscard]] HostTime true_time(DacTick tick) const {
        const double s = static_cast<double>(tick.n - first) / rate;
        const double early = 1e-6 * (ppm_ + ppm_a_minute_ * s / 120) * s;
        return HostTime{nanoseconds{31'536'000'000'000'000 + std::llround(1e9 * (s - early))}} + shift_;
    }
    [[nodiscard]] double ppm_now() const {
        return ppm_ + ppm_a_minute_ * static_cast<double>(next_.n - first) / rate / 60;
    }
    void play(ClockTracker<struct DacClock>& tracker, double for_s) {
        const auto blocks = static_cast<int>(for_s * rate / block);
        for (int i = 0; i < blocks; ++i) {
            tracker.add(next_, true_time(next_) + nanoseconds{std::llround(1e9 * delay_s_(random_))});
            next_.n += block;
        }
    }
    void stall(std::chrono::milliseconds time) { shift_ += time; }
    [[nodiscard]] DacTick next() const { return next_; }

private:
    static constexpr std::int64_t first = 123'456'789;
    double ppm_;
    double ppm_a_minute_;
    std::function<double(std::mt19937_64&)> delay_s_;
    std::mt19937_64 random_;
    DacTick next_{first};
    nanoseconds shift_{};
};

constexpr double shortest = 50e-6;
double usual_delay(std::mt19937_64& random) {
    return shortest + std::exponential_distribution<double>{1 / 100e-6}(random);
}

/// Error of the map at the newest tick, s: map minus true time and shortest delay. The map is used there, and
/// its error is largest there.
double error(const ClockTracker<struct DacClock>& tracker, const Device& device) {
    const auto off = tracker.map().value().at(device.next()) - device.true_time(device.next());
    return Seconds{off}.count() - shortest;
}

TEST(ClockTrackerTest, FindsRateTo1ppmAndOffsetTo5usAfter10s) {
    double sum = 0;
    constexpr int devices = 20;
    for (unsigned seed = 1; seed <= devices; ++seed) {
        ClockTracker<struct DacClock> tracker{rate};
        Device device{37.5, usual_delay, seed};
        device.play(tracker, 10);
        EXPECT_NEAR(tracker.ppm(), 37.5, 1) << "seed " << seed;
        EXPECT_LT(std::abs(error(tracker, device)), 5e-6) << "seed " << seed;
        EXPECT_NEAR(tracker.residual().count(), 100e-6,
                    10e-6);  // mean of the exponential law, of 1875 delays
        sum += error(tracker, device);
    }
    EXPECT_LT(std::abs(sum / devices), 1e-6) << "the mean delay of 150 us must have no effect";
}

TEST(ClockTrackerTest, LateSpikesDoNotChangeFit) {
    const auto spiky = [](std::mt19937_64& random) {
        std::uniform_real_distribution<double> unit{0, 1};
        const double spike = unit(random) < 0.03 ? 0.5 * unit(random) : 0;  // up to half a second
        return usual_delay(random) + spike;
    };
    for (unsigned seed = 1; seed <= 5; ++seed) {
        ClockTracker<struct DacClock> tracker{rate};
        Device device{-61, spiky, seed};
        device.play(tracker, 30);
        EXPECT_NEAR(tracker.ppm(), -61, 0.5);
        EXPECT_LT(std::abs(error(tracker, device)), 2e-6);
        EXPECT_GT(tracker.residual().count(), 5e-3) << "the residual must show the late stamps";
    }
}

TEST(ClockTrackerTest, UncertaintyCoversErrorFromFirstStamp) {
    int outside = 0;
    int all = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
        ClockTracker<struct DacClock> tracker{rate};
        Device device{seed % 2 ? 37.5 : -80.0, usual_delay, seed};
        for (const double s : {0.02, 0.6, 1.0, 1.0, 3.0, 15.0, 10.0}) {
            device.play(tracker, s);
            outside += std::abs(error(tracker, device)) > 3 * tracker.map()->sigma_at(device.next()).count();
            ++all;
        }
    }
    EXPECT_LE(outside, all / 50) << "of " << all << " maps, outside of 3 sigma";
}

// The delays of a busy computer are correlated: they vary with a time constant of 0.2 s.
TEST(ClockTrackerTest, RateUncertaintyCoversCorrelatedDelays) {
    int outside = 0;
    double squares = 0;  // of the error, in standard errors
    constexpr int seeds = 200;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
        ClockTracker<struct CameraClock> tracker{200};
        std::mt19937 rng{seed};
        std::normal_distribution<double> normal;
        const double keep = std::exp(-1 / (200 * 0.2));
        double wander = normal(rng);
        for (std::int64_t n = 0; n < 1000; ++n) {
            wander = keep * wander + std::sqrt(1 - keep * keep) * normal(rng);
            const double ns = 5e6 * static_cast<double>(n) / (1 + 25e-6) + 1e6 * std::abs(wander);
            tracker.add({n}, HostTime{std::chrono::nanoseconds{std::llround(ns)}});
        }
        const double off = (tracker.ppm() - 25) / tracker.ppm_sigma();
        outside += std::abs(off) > 2 ? 1 : 0;
        squares += off * off / seeds;
    }
    EXPECT_LE(outside, seeds / 10) << "of " << seeds << " outside of 2 sigma";
    EXPECT_GT(std::sqrt(squares), 0.2) << "the standard errors must not be far too large";
}

TEST(ClockTrackerTest, ARestartForgetsTheOffsetAndKeepsTheRate) {
    ClockTracker<struct DacClock> tracker{rate};
    Device device{37.5, usual_delay, 3};
    device.play(tracker, 20);
    device.stall(std::chrono::milliseconds{250});
    tracker.restart();
    EXPECT_FALSE(tracker.map().has_value());
    device.play(tracker, 1);
    EXPECT_NEAR(tracker.ppm(), 37.5, 0.5);
    EXPECT_LT(std::abs(error(tracker, device)), 20e-6);  // the least of 100 delays is 1 us late on average
    device.play(tracker, 20);
    EXPECT_NEAR(tracker.ppm(), 37.5, 0.5);
    EXPECT_LT(std::abs(error(tracker, device)), 2e-6);
}

TEST(ClockTrackerTest, FollowsACrystalThatWarmsUp) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
        ClockTracker<struct DacClock> tracker{rate};
        Device device{20, usual_delay, seed, 1};
        for (int i = 0; i < 20; ++i) {
            device.play(tracker, 10);
            // The line lags by 10 s, in which the rate has changed by 1/6 ppm and the time by half of that
            // times 10 s.
            EXPECT_NEAR(tracker.ppm(), device.ppm_now(), 0.5);
            EXPECT_LT(std::abs(error(tracker, device)), 3e-6);
            EXPECT_LT(std::abs(error(tracker, device)), 3 * tracker.map()->sigma_at(device.next()).count());
        }
    }
}

TEST(ClockTrackerTest, MapsWithNominalRateAtFirst) {
    ClockTracker<struct DacClock> tracker{rate};
    EXPECT_FALSE(tracker.map().has_value());
    EXPECT_EQ(tracker.ppm(), 0);
    tracker.add(DacTick{5}, HostTime{nanoseconds{1000}});
    ASSERT_TRUE(tracker.map().has_value());
    EXPECT_EQ(tracker.map()->at(DacTick{5}), HostTime{nanoseconds{1000}});
    EXPECT_EQ(tracker.ppm(), 0);
}

TEST(ClockTrackerTest, IgnoresTicksThatDoNotIncrease) {
    ClockTracker<struct DacClock> tracker{rate};
    Device device{37.5, usual_delay, 6};
    device.play(tracker, 10);
    const double before = tracker.ppm();
    tracker.add(DacTick{7}, device.true_time(device.next()) - std::chrono::seconds{1});
    device.play(tracker, 1);
    EXPECT_NEAR(tracker.ppm(), before, 0.2);
}

TEST(ClockTrackerTest, ManyStampsShortenWindow) {
    ClockTracker<struct CameraClock> tracker{2000};
    std::mt19937_64 random{8};
    for (std::int64_t n = 0; n < 100000; ++n) {
        const double s = static_cast<double>(n) / (2000 * (1 + 12e-6)) + usual_delay(random);
        tracker.add({n}, HostTime{nanoseconds{std::llround(1e9 * s)}});
    }
    EXPECT_NEAR(tracker.ppm(), 12, 0.2);
}

TEST(ClockTrackerTest, DoesNotAllocate) {
    ClockTracker<struct DacClock> tracker{rate};
    const test::NoAlloc guard;
    for (std::int64_t n = 0; n < 30000; ++n)
        tracker.add({n * block}, HostTime{nanoseconds{n * 5'333'333 + n % 17 * 1000}});
    tracker.restart();
    tracker.add({0}, HostTime{});
}

}  // namespace
}  // namespace shaker::calibration
