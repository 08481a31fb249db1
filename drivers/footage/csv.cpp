#include "drivers/footage/csv.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"
#include "drivers/time.hpp"

namespace shaker::footage {

namespace {

constexpr std::size_t first_row_line = 2;

void split(std::string_view line, std::vector<std::string_view>& fields) {
    fields.clear();
    while (true) {
        const auto comma = line.find(',');
        fields.push_back(trimmed(line.substr(0, comma)));
        if (comma == std::string_view::npos) return;
        line.remove_prefix(comma + 1);
    }
}

std::vector<std::string> header_of(std::string_view line) {
    if (line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
    std::vector<std::string_view> fields;
    split(line, fields);
    std::vector<std::string> names;
    for (auto field : fields) {
        const bool quoted = field.size() >= 2 && field.front() == '"' && field.back() == '"';
        names.emplace_back(quoted ? field.substr(1, field.size() - 2) : field);
    }
    return names;
}

std::string in_quotes(std::string_view text) {
    std::string quoted{'"'};
    quoted.append(text).push_back('"');
    return quoted;
}

std::size_t column_of(const std::string& name, const std::vector<std::string>& header,
                      const std::string& file) {
    const auto count = std::count(header.begin(), header.end(), name);
    if (count == 1)
        return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
    std::string there;
    for (const auto& word : header) there += (there.empty() ? "" : ", ") + in_quotes(word);
    throw InputError{file + ":1: column " + in_quotes(name) +
                     (count == 0 ? " is missing" : " is present " + std::to_string(count) + " times") +
                     "; the columns are " + there};
}

std::optional<double> finite_number(std::string_view field) {
    if (field.starts_with('+') && !field.starts_with("+-")) field.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc{} || end != field.data() + field.size() || !std::isfinite(value)) return {};
    return value;
}

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

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string CsvColumns::where(std::size_t row) const {
    return file.string() + ":" + std::to_string(row + first_row_line);
}

CsvColumns read_csv(const std::filesystem::path& file, std::span<const std::string> names) {
    const std::string name = file.string();
    if (std::filesystem::is_directory(file)) throw InputError{name + ": is a folder, not a table"};
    std::ifstream in{file, std::ios::binary};
    if (!in) throw InputError{name + ": cannot be opened: " + std::strerror(errno)};
    std::string line;
    if (!std::getline(in, line)) throw InputError{name + ": is empty; expected a header row"};
    const std::vector<std::string> header = header_of(line);

    CsvColumns table{file, {names.begin(), names.end()}, std::vector<std::vector<double>>(names.size())};
    std::vector<std::size_t> columns;
    for (const auto& wanted : names) columns.push_back(column_of(wanted, header, name));

    std::vector<std::string_view> fields;
    std::size_t blank_lines = 0;
    for (std::size_t row = 0; std::getline(in, line);) {
        if (trimmed(line).empty()) {
            ++blank_lines;
            continue;
        }
        if (blank_lines > 0) throw InputError{table.where(row) + ": blank row in the middle of the table"};
        split(line, fields);
        if (fields.size() != header.size())
            throw InputError{table.where(row) + ": this row has " + std::to_string(fields.size()) +
                             " fields, the header has " + std::to_string(header.size())};
        for (std::size_t i = 0; i < columns.size(); ++i) {
            const auto value = finite_number(fields[columns[i]]);
            if (!value)
                throw InputError{table.where(row) + ": column " + in_quotes(names[i]) + ": " +
                                 in_quotes(fields[columns[i]]) + " is not a finite number"};
            table.values[i].push_back(*value);
        }
        ++row;
    }
    if (in.bad()) throw DeviceError{name + ": cannot be read: " + std::strerror(errno)};
    if (table.values.front().empty()) throw InputError{name + ": has a header but no rows"};
    return table;
}

void require_increasing(const CsvColumns& table) {
    const auto& t = table.values.front();
    for (std::size_t row = 1; row < t.size(); ++row)
        if (!(t[row] > t[row - 1]))
            throw InputError{table.where(row) + ": column " + in_quotes(table.names.front()) +
                             " must increase from row to row, but " + to_text(t[row]) + " follows " +
                             to_text(t[row - 1])};
}

std::unique_ptr<Accelerometer> open_csv_accelerometer(const CsvAccelerometerFile& description) {
    return std::make_unique<CsvAccelerometer>(description);
}

}  // namespace shaker::footage
