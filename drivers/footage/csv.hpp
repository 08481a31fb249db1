#pragma once
// Reads columns of numbers from a comma-separated text file, strictly: a field that is not a number is an
// error with its line.
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace shaker::footage {

/// Named columns of one file: equal length, at least one row.
struct CsvColumns {
    std::filesystem::path file;
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;  // values[column][row]
    /// "file:line", for messages.
    [[nodiscard]] std::string where(std::size_t row) const;
};

/// Reads the columns `names`, in this order, from a file whose first row is a header. Ignored: blanks around
/// fields, quotes around column names, CRLF, a byte order mark, blank lines at the end. Throws InputError
/// with file, line and column when the file is missing or has no rows, a column is missing or duplicate, a
/// row differs from the header in its number of fields, or a field is not a finite number.
CsvColumns read_csv(const std::filesystem::path& file, std::span<const std::string> names);

/// Throws InputError with the line when the first column does not increase from row to row.
void require_increasing(const CsvColumns& table);

}  // namespace shaker::footage
