// Error of a clock fitted to late stamps: the line below them, against least squares through them.
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "calibration/clocks/clock_tracker.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/cost.hpp"

namespace shaker {
namespace {

using Delay = std::function<double(std::mt19937_64&)>;

constexpr double rate = 48000;
constexpr std::int64_t block = 256;
constexpr double shortest_s = 50e-6;
constexpr double ppm = 37.5;
constexpr int devices = 50;
constexpr std::size_t window = 3750;  // stamps in 20 s

struct Stamps {
    std::vector<double> true_s;
    std::vector<double> stamp_s;
};

Stamps stamps(const Delay& delay, double for_s, unsigned seed) {
    std::mt19937_64 random{seed};
    Stamps all;
    for (std::int64_t n = 0; static_cast<double>(n) < for_s * rate; n += block) {
        all.true_s.push_back(static_cast<double>(n) / (rate * (1 + 1e-6 * ppm)));
        all.stamp_s.push_back(all.true_s.back() + shortest_s + delay(random));
    }
    return all;
}

/// Errors of a method at the newest stamp: time (s, without the shortest delay) and rate (ppm).
struct Errors {
    double time;
    double rate;
};

Errors under(const Stamps& all) {
    calibration::ClockTracker<struct DacClock> tracker{rate};
    DacTick tick;
    for (const double s : all.stamp_s) {
        tracker.add(tick, HostTime{std::chrono::nanoseconds{std::llround(1e9 * s)}});
        tick.n += block;
    }
    tick.n -= block;
    const Seconds mapped = tracker.map()->at(tick).time_since_epoch();
    return {mapped.count() - all.true_s.back() - shortest_s, tracker.ppm() - ppm};
}

Errors through(const Stamps& all) {
    const std::size_t n = std::min(all.stamp_s.size(), window);
    const std::size_t first = all.stamp_s.size() - n;
    double mean_x = 0;
    double mean_y = 0;
    for (std::size_t i = first; i < first + n; ++i) {
        mean_x += static_cast<double>(i) / static_cast<double>(n);
        mean_y += all.stamp_s[i] / static_cast<double>(n);
    }
    double xy = 0;
    double xx = 0;
    for (std::size_t i = first; i < first + n; ++i) {
        const double x = static_cast<double>(i) - mean_x;
        xy += x * (all.stamp_s[i] - mean_y);
        xx += x * x;
    }
    const double slope = xy / xx;
    const double mapped = mean_y + slope * (static_cast<double>(first + n - 1) - mean_x);
    return {mapped - all.true_s.back() - shortest_s, 1e6 * (block / rate / slope - 1) - ppm};
}

void add(bench::Table& table, const std::string& method, Errors (*fit)(const Stamps&), const std::string& law,
         const Delay& delay, double for_s) {
    double sum = 0;
    double squares = 0;
    double largest = 0;
    double rate_squares = 0;
    for (unsigned seed = 1; seed <= devices; ++seed) {
        const Errors e = fit(stamps(delay, for_s, seed));
        sum += e.time;
        squares += e.time * e.time;
        largest = std::max(largest, std::abs(e.time));
        rate_squares += e.rate * e.rate;
    }
    const Stamps all = stamps(delay, for_s, 1);
    const double cost = bench::median_cost_ns(5, [&] { fit(all); }) / static_cast<double>(all.stamp_s.size());
    table.add({{"method", method},
               {"delay beyond 50 us", law},
               {"after", for_s, "s"},
               {"cost", cost, "ns a stamp"},
               {"bias", 1e6 * sum / devices, "us"},
               {"rms error", 1e6 * std::sqrt(squares / devices), "us"},
               {"largest", 1e6 * largest, "us"},
               {"rms rate error", std::sqrt(rate_squares / devices), "ppm"}});
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) {
    using namespace shaker;
    const auto exponential = [](std::mt19937_64& random) {
        return std::exponential_distribution<double>{1 / 100e-6}(random);
    };
    const auto spikes = [](std::mt19937_64& random) {
        std::uniform_real_distribution<double> unit{0, 1};
        const double spike = unit(random) < 0.03 ? 2e-3 * unit(random) : 0;
        return std::exponential_distribution<double>{1 / 50e-6}(random) + spike;
    };
    bench::Table table;
    for (const double after : {2.5, 10.0, 30.0}) {
        for (const auto& [law, delay] : {std::pair<std::string, Delay>{"exp(100 us)", exponential},
                                         {"exp(50 us), 3 % to 2 ms", spikes}}) {
            add(table, "line under stamps", under, law, delay, after);
            add(table, "least squares, 20 s", through, law, delay, after);
        }
    }
    table.print(argc, argv);
}
