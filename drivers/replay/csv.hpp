#pragma once
// Columns of numbers from a comma-separated text file, read strictly: whatever is not a number is an error
// with its line.
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace shaker {

/// Named columns of one file, all of the same length, at least one row.
struct CsvColumns {
    std::filesystem::path file;
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;  // values[column][row]
    /// "file:line", for messages.
    [[nodiscard]] std::string where(std::size_t row) const;
};

/// Reads `names` (in that order) from a file whose first row is a header. Blanks around fields, quotes around
/// column names, CRLF, a byte order mark and blank lines at the end do not matter. Throws InputError naming
/// file, line and column when the file is not there or has no rows, a column is not there or is there twice,
/// a row has more or fewer fields than the header, or a field is not a finite number.
CsvColumns read_csv(const std::filesystem::path& file, std::span<const std::string> names);

/// Throws InputError naming the line when the first column does not increase from row to row.
void require_increasing(const CsvColumns& table);

}  // namespace shaker
