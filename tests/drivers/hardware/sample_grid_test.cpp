#include "drivers/hardware/iio/sample_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "tests/support/no_alloc.hpp"

namespace shaker::hardware {
namespace {

constexpr double rate_hz = 4000;
constexpr std::int64_t ms = 1'000'000;

/// A sensor that numbers its samples in counts[0].
struct Sensor {
    double step_ns = 1e9 / rate_hz;
    std::int64_t begin_ns = 5'000'000'000;
    std::int64_t delay_ns = 300'000;  // from the sample to the host

    [[nodiscard]] iio::TimedSample sample(std::int64_t n) const {
        const std::int64_t at = begin_ns + std::llround(step_ns * static_cast<double>(n));
        return {{static_cast<std::int32_t>(n), 0, 0}, at, at + delay_ns};
    }
};

/// Passes samples to a grid and takes the placed ones.
struct Numbering {
    iio::SampleGrid grid{rate_hz};
    std::vector<iio::PlacedSample> placed{};
    void add(const iio::TimedSample& sample) {
        grid.add(sample);
        while (const auto p = grid.next()) placed.push_back(*p);
    }
    [[nodiscard]] std::int64_t lost() const {
        std::int64_t sum = 0;
        for (const iio::PlacedSample& p : placed) sum += p.lost;
        return sum;
    }
    /// Checks that every tick equals the sensor's own number.
    [[nodiscard]] bool exact() const {
        for (const iio::PlacedSample& p : placed)
            if (p.tick != p.sample.counts[0] - placed.front().sample.counts[0]) return false;
        return !placed.empty();
    }
};

TEST(SampleGridTest, PunctualSamplesAreNumberedInARow) {
    Numbering run;
    const Sensor sensor;
    for (int n = 0; n < 10000; ++n) run.add(sensor.sample(n));
    EXPECT_EQ(run.placed.size(), 10000U);  // no sample is held back once the rate is known
    EXPECT_EQ(run.lost(), 0);
    EXPECT_TRUE(run.exact());
}

TEST(SampleGridTest, FollowsRateOtherThanNominal) {
    for (const double error : {-0.10, -0.03, 0.002, 0.10}) {
        Numbering run;
        Sensor sensor;
        sensor.step_ns *= 1 + error;
        for (int n = 0; n < 40000; ++n) run.add(sensor.sample(n));
        EXPECT_EQ(run.lost(), 0) << error;
        EXPECT_NEAR(run.grid.step_ns() / sensor.step_ns, 1, 1e-6) << error;  // stamps are whole nanoseconds
    }
}

TEST(SampleGridTest, ARateThatDriftsIsFollowed) {
    Numbering run;
    Sensor sensor;
    double at = 0;
    for (int n = 0; n < 100000; ++n) {  // 25 s, by +-1 %: a thousand times the effect of warming up
        at += sensor.step_ns * (1 + 0.01 * std::sin(n * 2e-4));
        iio::TimedSample sample = sensor.sample(n);
        sample.stamp_ns = sensor.begin_ns + std::llround(at);
        sample.arrived_ns = sample.stamp_ns + sensor.delay_ns;
        run.add(sample);
    }
    EXPECT_EQ(run.lost(), 0);
}

/// Stamps like those of an interrupt on a busy processor: late in bursts of up to 4.6 ms, 18 steps.
class BusyProcessor {
public:
    iio::TimedSample stamped(iio::TimedSample sample) {
        if (sample.stamp_ns >= free_ && std::bernoulli_distribution{0.01}(random_))
            free_ = sample.stamp_ns + std::uniform_int_distribution<std::int64_t>{0, 4'600'000}(random_);
        std::normal_distribution<double> usual{20e3, 10e3};
        const auto late = static_cast<std::int64_t>(std::abs(usual(random_)));
        last_ = std::max({sample.stamp_ns + late, free_, last_ + 6000});
        sample.stamp_ns = last_;
        sample.arrived_ns = std::max(sample.arrived_ns, last_ + 100'000);
        return sample;
    }

private:
    std::int64_t free_ = 0, last_ = 0;
    std::mt19937_64 random_{3};
};

TEST(SampleGridTest, BurstsOfLateStampsAreNotLosses) {
    Numbering run;
    const Sensor sensor;
    BusyProcessor processor;
    for (int n = 0; n < 60000; ++n) run.add(processor.stamped(sensor.sample(n)));
    EXPECT_EQ(run.lost(), 0);
    EXPECT_TRUE(run.exact());
    EXPECT_GT(run.placed.size(), 59700U);
}

TEST(SampleGridTest, SamplesThatShareAStampAreNotLosses) {
    Numbering run;  // a FIFO of eight in the sensor, stamped when it is full
    const Sensor sensor;
    for (int n = 0; n < 20000; ++n) {
        iio::TimedSample sample = sensor.sample(n);
        sample.stamp_ns = sensor.sample(n - n % 8 + 7).stamp_ns;
        run.add(sample);
    }
    EXPECT_EQ(run.lost(), 0);
    EXPECT_TRUE(run.exact());
}

TEST(SampleGridTest, EveryLossIsCountedAtItsPlace) {
    Numbering run;
    const Sensor sensor;
    std::mt19937_64 random{11};
    std::int64_t lost = 0;
    for (int n = 0; n < 100000;) {
        run.add(sensor.sample(n));
        ++n;
        if (n > 2000 && n < 99000 && std::bernoulli_distribution{0.003}(random)) {
            const int gap = std::geometric_distribution<int>{0.1}(random) + 1;
            lost += gap;
            n += gap;
        }
    }
    EXPECT_GT(lost, 2000);
    EXPECT_EQ(run.lost(), lost);
    EXPECT_TRUE(run.exact());
}

TEST(SampleGridTest, LossesAmongLateStampsAreCountedToo) {
    Numbering run;
    const Sensor sensor;
    BusyProcessor processor;
    std::int64_t lost = 0;
    for (int n = 0; n < 100800; ++n) {
        if (n > 2000 && n % 1009 < 3) {  // three in a row
            ++lost;
            continue;
        }
        run.add(processor.stamped(sensor.sample(n)));
    }
    EXPECT_EQ(run.lost(), lost);
    EXPECT_EQ(run.placed.back().tick, run.placed.back().sample.counts[0]);
}

TEST(SampleGridTest, CountsLossesForHoursWithLateStamps) {
    constexpr std::int64_t samples = 20'000'000;  // 83 minutes
    iio::SampleGrid grid{rate_hz};
    const Sensor sensor;
    std::mt19937_64 random{5};
    std::exponential_distribution<double> late{1 / 100e3};  // ns: an eighth of them by more than a whole step
    std::geometric_distribution<std::int64_t> apart{1.0 / 20000};
    std::uniform_int_distribution<std::int64_t> gap{1, 300};
    std::int64_t lost = 0, counted = 0, displaced = 0, next_loss = 5000;
    for (std::int64_t n = 0; n < samples; ++n) {
        if (n == next_loss && n < samples - 10000) {
            const std::int64_t missing = gap(random);
            lost += missing;
            n += missing;
            next_loss = n + 1 + apart(random);
        }
        iio::TimedSample sample = sensor.sample(n);
        sample.stamp_ns += std::llround(late(random));
        sample.counts[0] = static_cast<std::int32_t>(n);
        grid.add(sample);
        while (const auto p = grid.next()) {
            counted += p->lost;
            if (p->tick != p->sample.counts[0]) ++displaced;
        }
    }
    EXPECT_GT(lost, 100000);
    EXPECT_EQ(counted, lost);
    // A late stamp just before a loss may be taken for its first sample.
    EXPECT_LT(displaced, 200);
}

TEST(SampleGridTest, ALossWhileTheRateIsMeasuredIsCounted) {
    Numbering run;
    const Sensor sensor;
    for (int n = 0; n < 5000; ++n)
        if (n < 300 || n >= 307) run.add(sensor.sample(n));
    EXPECT_EQ(run.lost(), 7);
    EXPECT_TRUE(run.exact());
}

TEST(SampleGridTest, AQuarterOfAllSamplesLostFromTheStartIsCounted) {
    Numbering run;  // a trigger with misses: the nominal rate is reliable, the median step is not
    const Sensor sensor;
    std::mt19937_64 random{5};
    std::int64_t last = 0;
    for (int n = 0; n < 40000; ++n) {
        if (n > 0 && std::bernoulli_distribution{0.24}(random)) continue;
        run.add(sensor.sample(n));
        last = n;
    }
    EXPECT_EQ(run.placed.back().tick, run.placed.back().sample.counts[0]);
    EXPECT_LT(last - run.placed.back().tick, 400);  // what is still held back
}

TEST(SampleGridTest, ALongOutageIsCountedInTime) {
    Numbering run;
    const Sensor sensor;
    for (int n = 0; n < 50000; ++n)
        if (n < 8000 || n >= 28000) run.add(sensor.sample(n));  // 5 s
    EXPECT_EQ(run.lost(), 20000);
    EXPECT_TRUE(run.exact());
    EXPECT_EQ(run.grid.clock_steps(), 0U);
}

TEST(SampleGridTest, CountsLossWhileHostIsLate) {
    Numbering run;  // after an overflow the content of the FIFO arrives late, together with the samples after
                    // the gap
    const Sensor sensor;
    const std::int64_t back = sensor.sample(12000).arrived_ns;
    for (int n = 0; n < 20000; ++n) {
        if (n >= 9000 && n < 12000) continue;
        iio::TimedSample sample = sensor.sample(n);
        if (n >= 8000) sample.arrived_ns = std::max(sample.arrived_ns, back);
        run.add(sample);
    }
    EXPECT_EQ(run.lost(), 3000);
    EXPECT_TRUE(run.exact());
}

TEST(SampleGridTest, ClockStepIsNoLossAndStampsContinue) {
    for (const std::int64_t step : {1000 * ms, 25 * ms, -25 * ms, -3'000'000 * ms}) {
        Numbering run;
        const Sensor sensor;
        std::mt19937_64 random{2};
        for (int n = 0; n < 20000; ++n) {
            iio::TimedSample sample = sensor.sample(n);
            // Transfers of 64 samples, some of them after a stall of 100 ms.
            const std::int64_t stall = n / 400 % 7 == 3 ? 100 * ms - n % 400 * 250'000LL : 0;
            sample.arrived_ns +=
                std::max(std::int64_t{0}, stall) + static_cast<std::int64_t>(random() % 200000);
            if (n >= 9000) sample.stamp_ns += step;
            run.add(sample);
        }
        EXPECT_EQ(run.lost(), 0) << step;
        EXPECT_TRUE(run.exact()) << step;
        EXPECT_EQ(run.grid.clock_steps(), 1U) << step;
        for (const iio::PlacedSample& p : run.placed)
            ASSERT_NEAR(static_cast<double>(p.sample.stamp_ns - sensor.sample(p.tick).stamp_ns), 0, 10)
                << step;
    }
}

TEST(SampleGridTest, ContinuesAtHostTimeAfterDeviceRestart) {
    Numbering run;  // its clock restarts; the arrival determines the place in time
    const Sensor sensor;
    for (int n = 0; n < 50000; ++n) {
        if (n >= 8000 && n < 28000) continue;
        iio::TimedSample sample = sensor.sample(n);
        if (n >= 28000) sample.stamp_ns -= 12'000'000'000;
        run.add(sample);
    }
    EXPECT_EQ(run.lost(), 20000);  // exact here because the delay is constant
    EXPECT_EQ(run.grid.clock_steps(), 1U);
}

TEST(SampleGridTest, IgnoresInvalidStamp) {
    Numbering run;
    const Sensor sensor;
    const std::vector<std::int64_t> nonsense{0, INT64_MAX, INT64_MIN, -1, 4'999'000'000, 6'000'000'000};
    for (int n = 0; n < 20000; ++n) {
        iio::TimedSample sample = sensor.sample(n);
        if (n > 2000 && n % 1000 == 0) sample.stamp_ns = nonsense[static_cast<std::size_t>(n / 1000) % 6];
        run.add(sample);
    }
    EXPECT_EQ(run.lost(), 0);
    EXPECT_TRUE(run.exact());
    EXPECT_EQ(run.grid.clock_steps(), 0U);
}

TEST(SampleGridTest, ConstantStampsLoseNoSamples) {
    Numbering run;
    const Sensor sensor;
    for (int n = 0; n < 20000; ++n) {
        iio::TimedSample sample = sensor.sample(n);
        if (n >= 4000 && n < 12000) sample.stamp_ns = sensor.sample(4000).stamp_ns;
        run.add(sample);
    }
    EXPECT_EQ(run.placed.size() + 2000, std::max<std::size_t>(run.placed.size() + 2000, 20000));
    EXPECT_LE(run.lost(), 1);
}

TEST(SampleGridTest, SlowSensorsAreNumberedToo) {
    iio::SampleGrid grid{50};
    std::vector<std::int64_t> ticks;
    for (int n = 0; n < 400; ++n) {
        if (n == 200 || n == 201) continue;
        grid.add({{n, 0, 0}, 20 * ms * n, 20 * ms * n + ms});
        while (const auto p = grid.next()) ticks.push_back(p->tick - p->sample.counts[0]);
    }
    ASSERT_EQ(ticks.size(), 398U);
    EXPECT_EQ(ticks.back(), 0);
}

TEST(SampleGridTest, DoesNotAllocateAfterConstruction) {
    iio::SampleGrid grid{rate_hz};
    const Sensor sensor;
    std::int64_t placed = 0;
    const test::NoAlloc guard;
    for (int n = 0; n < 8000; ++n) {
        if (n % 1500 == 7) continue;
        grid.add(sensor.sample(n));
        while (grid.next()) ++placed;
    }
    EXPECT_GT(placed, 7000);
}

}  // namespace
}  // namespace shaker::hardware
