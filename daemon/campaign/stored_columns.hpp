#pragma once
// A points table as it lies in a file: one column for each point, or a matrix with one row for each point.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/h5.hpp"

namespace shaker::campaign {

/// Columns of the points that tables of before do not have: NaN, or an empty text.
inline constexpr std::array<std::string_view, 6> later_columns{"points/doubt",       "points/tilt",
                                                               "points/tilt_errors", "points/phi_systematic",
                                                               "points/corner",      "points/corner_errors"};

/// Returns the columns as they are in the rows. across: rows of one point in a matrix; 0: columns.
class StoredColumns {
public:
    StoredColumns(hid_t entry, std::size_t across) : entry_{entry}, across_{across} {}
    [[nodiscard]] std::vector<double> numbers(const std::string& path) const {
        if (missing(path)) return std::vector<double>(points("points"), NAN);
        std::vector<double> values = h5::read<double>(entry_, path);
        if (across_ == 0) return values;
        const std::string group = path.substr(0, path.find('/'));
        if (h5::description_of(entry_, path).shape.size() == 2) return values;
        const bool outer = path == group + "/point";
        const std::size_t rows = points(group) * across_;
        if (rows == 0) return {};
        if (!outer && values.size() != across_)
            throw InputError{fmt::format("{} has {} values, expected {}", path, values.size(), across_)};
        std::vector<double> all;
        for (std::size_t i = 0; i < rows; ++i) all.push_back(values[outer ? i / across_ : i % across_]);
        return all;
    }
    [[nodiscard]] std::vector<std::string> texts(const std::string& path) const {
        if (missing(path)) return std::vector<std::string>(points("points"));
        return h5::read_texts(entry_, path);
    }

private:
    [[nodiscard]] bool missing(const std::string& path) const {
        return std::ranges::find(later_columns, path) != later_columns.end() && !h5::exists(entry_, path);
    }
    [[nodiscard]] std::size_t points(const std::string& group) const {
        const std::vector<hsize_t> shape = h5::description_of(entry_, group + "/point").shape;
        if (shape.size() != 1)
            throw InputError{
                fmt::format("{}/point has {} dimensions, expected a column", group, shape.size())};
        return shape.front();
    }

    hid_t entry_;
    std::size_t across_;
};

}  // namespace shaker::campaign
