#include "daemon/recording/tables/differences.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "daemon/recording/tables/measured_tables.hpp"
#include "drivers/errors.hpp"

namespace shaker::recording {

namespace {

bool same(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
           (std::isnan(a) && std::isnan(b));
}

const std::vector<double>& values_of(const std::vector<recorded::Column>& columns, const std::string& name,
                                     const std::string& path) {
    const auto it = std::ranges::find(columns, name, &recorded::Column::name);
    if (it == columns.end())
        throw InputError{"recording: table \"" + path + "\" has no column \"" + name + "\""};
    return it->values;
}

// " (measurement 3)" in a table with rows of several measurements, otherwise empty.
std::string measurement_at(const RecordedTable& table, std::size_t row) {
    if (table.columns.front().name != measurement_column) return {};
    return fmt::format(" (measurement {})", table.columns.front().values[row]);
}

}  // namespace

std::vector<std::string> differences(const recorded::RecordingReader& file,
                                     const std::vector<RecordedNumber>& numbers,
                                     const std::vector<RecordedTable>& tables) {
    std::vector<std::string> found;
    for (const RecordedNumber& n : numbers) {
        const double was = file.scalar(n.path);
        if (!same(was, n.value))
            found.push_back(fmt::format("{}: recorded {}, now {}", n.path, was, n.value));
    }
    for (const RecordedTable& t : tables) {
        const std::vector<recorded::Column> recorded = file.table(t.path);
        for (const recorded::Column& c : t.columns) {
            const std::vector<double>& was = values_of(recorded, c.name, t.path);
            if (was.size() != c.values.size()) {
                found.push_back(fmt::format("{}/{}: {} rows recorded, now {}", t.path, c.name, was.size(),
                                            c.values.size()));
                continue;
            }
            const auto [a, b] = std::ranges::mismatch(was, c.values, same);
            if (a == was.end()) continue;
            const auto row = static_cast<std::size_t>(a - was.begin());
            found.push_back(fmt::format("{}/{} row {}{}: recorded {}, now {}", t.path, c.name, row,
                                        measurement_at(t, row), *a, *b));
        }
    }
    return found;
}

}  // namespace shaker::recording
