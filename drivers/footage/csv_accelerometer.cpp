#include "drivers/footage/csv_accelerometer.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/footage/csv.hpp"
#include "drivers/footage/grid.hpp"
#include "drivers/quantity.hpp"
#include "drivers/time.hpp"

namespace shaker::footage {

namespace {

constexpr double jitter_allowed = 0.2;  // of a step
constexpr double most_mps2 = 1e6;
constexpr double most_counts = 2e9;

void require_regular(const CsvColumns& table, const Grid& grid) {
    const auto& t = table.values.front();
    if (grid.off_s <= jitter_allowed * grid.step_s) return;
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
    CsvAccelerometer(const CsvAccelerometerFile& description, const CsvColumns& table) {
        if (table.values.front().size() < 2)
            throw InputError{description.file.string() + ": at least two samples are required"};
        require_increasing(table);
        const std::vector<double>& t_s = table.values.front();
        Grid grid = fitted_grid(t_s, usual_step(t_s));
        require_regular(table, grid);
        const double scale = counts_per_mps2(table);
        counts_.resize(grid.ticks.size());
        for (std::size_t i = 0; i < counts_.size(); ++i)
            for (std::size_t axis = 0; axis < description.axes.size(); ++axis)
                counts_[i][axis] = static_cast<std::int32_t>(std::lround(table.values[axis + 1][i] * scale));
        ticks_ = std::move(grid.ticks);
        info_ = {.name = description.file.filename().string(),
                 .rate_hz = 1 / grid.step_s,
                 .axes = static_cast<int>(description.axes.size()),
                 .gravity = description.gravity,
                 .response = description.response,
                 .mps2_per_count = {},
                 .first_sample_s = grid.first_s,
                 .clock_uncertainty_s = description.clock_uncertainty_s,
                 .shaker_axis = description.shaker_axis};
        std::fill_n(info_.mps2_per_count.begin(), description.axes.size(), 1 / scale);
    }

    [[nodiscard]] AccelerometerInfo info() const override { return info_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return {.taken = taken_, .lost = lost_}; }

    bool read(AccelBlock& block, std::chrono::milliseconds) override {
        if (ended()) return false;
        block = {};
        block.first = AccelTick{ticks_[next_]};
        const bool gap = next_ > 0 && ticks_[next_] != ticks_[next_ - 1] + 1;
        block.quality = gap ? Quality::gap : Quality::good;
        if (gap) lost_ += static_cast<std::uint64_t>(ticks_[next_] - ticks_[next_ - 1] - 1);
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
        taken_ += size;
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
    std::atomic<std::uint64_t> taken_{0}, lost_{0};
    std::atomic<bool> stopped_ = false;
};

/// The unit of one column: as described, else as the table states it, else the standard one.
const CsvUnit* unit_of(const std::string& described, const CsvColumns& table, std::size_t column,
                       std::string_view standard, std::vector<std::string>& notes) {
    if (!described.empty()) return unit_in(described);
    const CsvUnit* stated = unit_in(table.names[column]);
    if (!table.units.empty()) stated = unit_in(table.units[column]);
    if (stated == nullptr) return unit_in(standard);
    if (stated->factor != 1)
        notes.push_back(table.file.string() + ": column \"" + table.names[column] + "\" is read in " +
                        std::string{stated->word} + ", as the table states");
    return stated;
}

void to_si(CsvColumns& table, std::size_t column, const CsvUnit& unit, bool time) {
    if (unit.of_time != time)
        throw InputError{table.file.string() + ": column \"" + table.names[column] + "\" is in " +
                         std::string{unit.word} + "; expected a unit of " + (time ? "time" : "acceleration")};
    for (double& value : table.values[column]) value *= unit.factor;
}

/// Time in s and the accelerations in m/s^2.
CsvColumns table_of(const CsvAccelerometerFile& description, std::vector<std::string>& notes) {
    std::vector<std::string> names{description.axes.begin(), description.axes.end()};
    if (!description.rate_hz) names.insert(names.begin(), description.time);
    CsvColumns table = read_csv(description.file, names);
    const std::size_t first = description.rate_hz ? 0 : 1;
    if (!description.rate_hz) to_si(table, 0, *unit_of(description.time_unit, table, 0, "s", notes), true);
    for (std::size_t axis = first; axis < names.size(); ++axis)
        to_si(table, axis, *unit_of(description.unit, table, axis, "m/s^2", notes), false);
    if (!description.rate_hz) return table;
    std::vector<double> times_s(table.values.front().size());
    for (std::size_t i = 0; i < times_s.size(); ++i)
        times_s[i] = description.first_sample_s + static_cast<double>(i) / *description.rate_hz;
    table.names.insert(table.names.begin(), "rate_hz");
    table.values.insert(table.values.begin(), std::move(times_s));
    return table;
}

}  // namespace

OpenCsvAccelerometer open_csv_accelerometer(const CsvAccelerometerFile& description) {
    OpenCsvAccelerometer open;
    const CsvColumns table = table_of(description, open.notes);
    open.accelerometer = std::make_unique<CsvAccelerometer>(description, table);
    return open;
}

}  // namespace shaker::footage
