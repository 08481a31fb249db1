#include "drivers/footage/csv_accelerometer.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/footage/csv.hpp"
#include "drivers/quantity.hpp"
#include "drivers/ticks.hpp"

namespace shaker::footage {
namespace {

constexpr double jitter_allowed = 0.2;  // of a step
constexpr double most_mps2 = 1e6;
constexpr double most_counts = 2e9;

/// Mean of the steps between neighbours. Stamps are rounded ("0.000333"), so a single step, or the median,
/// may be wrong by enough to miscount the samples of a long gap.
double usual_step(const std::vector<double>& t) {
    std::vector<double> steps(t.size() - 1);
    for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = t[i + 1] - t[i];
    std::vector<double> sorted = steps;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    double sum = 0, count = 0;
    for (const double step : steps)
        if (step > 0.5 * *middle && step < 1.5 * *middle) sum += step, ++count;
    return sum / count;
}

struct Grid {
    std::vector<std::int64_t> ticks;
    double first_s = 0;
    double step_s = 0;
};

/// Counts the samples, missing ones included, and fits a straight line to all stamps.
Grid fitted_grid(const std::vector<double>& t) {
    Grid grid;
    const double step = usual_step(t);
    grid.ticks.push_back(0);
    for (std::size_t i = 1; i < t.size(); ++i) {
        const double steps = std::clamp(std::round((t[i] - t[i - 1]) / step), 1.0, 1e15);
        grid.ticks.push_back(grid.ticks.back() + static_cast<std::int64_t>(steps));
    }
    double mean_n = 0, mean_t = 0;
    const auto count = static_cast<double>(t.size());
    for (std::size_t i = 0; i < t.size(); ++i) {
        mean_n += static_cast<double>(grid.ticks[i]) / count;
        mean_t += (t[i] - t.front()) / count;
    }
    double nn = 0, nt = 0;
    for (std::size_t i = 0; i < t.size(); ++i) {
        const double n = static_cast<double>(grid.ticks[i]) - mean_n;
        nn += n * n;
        nt += n * ((t[i] - t.front()) - mean_t);
    }
    grid.step_s = nt / nn;
    grid.first_s = t.front() + (mean_t - grid.step_s * mean_n);
    return grid;
}

void require_regular(const CsvColumns& table, const Grid& grid) {
    const auto& t = table.values.front();
    for (std::size_t i = 0; i < t.size(); ++i) {
        const double expected = grid.first_s + grid.step_s * static_cast<double>(grid.ticks[i]);
        if (std::abs(t[i] - expected) > jitter_allowed * grid.step_s)
            throw InputError{table.where(i) + ": " + to_text(t[i]) + " in column \"" + table.names.front() +
                             "\" is not within 20 % of a step of the regular grid of " +
                             to_text(1 / grid.step_s) + " samples/s (expected " + to_text(expected) +
                             "); resample the table first"};
    }
}

/// Counts per m/s^2: the largest power of ten for which every sample fits into 32 bits.
double counts_per_mps2(const CsvColumns& table) {
    double most = 0;
    for (std::size_t axis = 1; axis < table.values.size(); ++axis) {
        const auto& a = table.values[axis];
        for (std::size_t i = 0; i < a.size(); ++i) {
            if (std::abs(a[i]) > most_mps2)
                throw InputError{table.where(i) + ": " + to_text(a[i]) + " in column \"" + table.names[axis] +
                                 "\" is too large for an acceleration in m/s^2: at most 1e6"};
            most = std::max(most, std::abs(a[i]));
        }
    }
    double scale = 1e3;
    while (scale < 1e12 && most * scale * 10 < most_counts) scale *= 10;
    return scale;
}

class CsvAccelerometer final : public Accelerometer {
public:
    explicit CsvAccelerometer(const CsvAccelerometerFile& description) {
        const std::array<std::string, 4> names{description.time, description.axes[0], description.axes[1],
                                               description.axes[2]};
        const CsvColumns table = read_csv(description.file, names);
        if (table.values.front().size() < 2)
            throw InputError{description.file.string() + ": at least two samples are required"};
        require_increasing(table);
        Grid grid = fitted_grid(table.values.front());
        require_regular(table, grid);
        const double scale = counts_per_mps2(table);
        counts_.resize(grid.ticks.size());
        for (std::size_t i = 0; i < counts_.size(); ++i)
            for (std::size_t axis = 0; axis < 3; ++axis)
                counts_[i][axis] = static_cast<std::int32_t>(std::lround(table.values[axis + 1][i] * scale));
        ticks_ = std::move(grid.ticks);
        info_ = {.name = description.file.filename().string(),
                 .rate_hz = 1 / grid.step_s,
                 .mps2_per_count = {1 / scale, 1 / scale, 1 / scale},
                 .first_sample_s = grid.first_s,
                 .clock_uncertainty_s = description.clock_uncertainty_s,
                 .shaker_axis = description.shaker_axis};
    }

    [[nodiscard]] AccelerometerInfo info() const override { return info_; }

    bool read(AccelBlock& block, std::chrono::milliseconds) override {
        if (ended()) return false;
        block = {};
        block.first = AccelTick{ticks_[next_]};
        const bool gap = next_ > 0 && ticks_[next_] != ticks_[next_ - 1] + 1;
        block.quality = gap ? Quality::gap : Quality::good;
        std::size_t size = 0;
        const auto in_a_row = [&] {
            return ticks_[next_ + size] == block.first.n + static_cast<std::int64_t>(size);
        };
        while (size < AccelBlock::capacity && next_ + size < ticks_.size() && in_a_row()) {
            block.counts[size] = counts_[next_ + size];
            ++size;
        }
        block.size = static_cast<int>(size);
        next_ += size;
        const double last_s = info_.first_sample_s + duration_s(ticks_[next_ - 1], info_.rate_hz);
        block.arrived = HostTime{std::chrono::nanoseconds{std::llround(1e9 * last_s)}};
        return true;
    }

    [[nodiscard]] bool ended() const noexcept override { return stopped_ || next_ >= ticks_.size(); }
    void stop() noexcept override { stopped_ = true; }

private:
    AccelerometerInfo info_;
    std::vector<std::int64_t> ticks_;
    std::vector<std::array<std::int32_t, 3>> counts_;
    std::size_t next_ = 0;
    std::atomic<bool> stopped_ = false;
};

}  // namespace

std::unique_ptr<Accelerometer> open_csv_accelerometer(const CsvAccelerometerFile& description) {
    return std::make_unique<CsvAccelerometer>(description);
}

}  // namespace shaker::footage
