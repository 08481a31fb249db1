#pragma once
// Text tables of loggers and of other programs: columns of numbers, read strictly (a field that is not a
// number is an error with its line).
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace shaker::footage {

/// Without blanks at its ends.
std::string_view trimmed(std::string_view text);

/// A unit that loggers write: its word, without brackets, and its factor to s or m/s^2.
struct CsvUnit {
    std::string_view word;
    double factor;
    bool of_time;
};
/// The unit of "ms", "(ms)" or "Time (ms)"; null for a text without one.
const CsvUnit* unit_in(std::string_view text) noexcept;

/// Named columns of one file: equal length, at least one row.
struct CsvColumns {
    std::filesystem::path file;
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;  // values[column][row]
    std::vector<std::string> units;           // texts of the row of units; empty: no such row
    std::size_t first_line = 2;               // of the first row, from 1
    /// "file:line", for messages.
    [[nodiscard]] std::string where(std::size_t row) const;
};

/// Reads the columns `names`, in this order. The heading is the first line that has them all; the lines above
/// it describe the recording and are left out, as are lines that begin with '#'. The fields are separated by
/// commas, semicolons or tabs, as the heading is; numbers may have a decimal comma where that is no
/// separator. Quotes as in RFC 4180, but no line ends in them. UTF-8 and UTF-16 with their marks; lines end
/// with CR, LF or both; blank lines at the end are left out. Throws InputError with file, line and column
/// when the file is missing, no text, or has no rows, a column is missing or duplicate, a row differs from
/// the heading in its number of fields, or a field is not a finite number. A message has at most 200
/// characters of the file.
CsvColumns read_csv(const std::filesystem::path& file, std::span<const std::string> names);

/// Throws InputError with the line when the first column does not increase from row to row.
void require_increasing(const CsvColumns& table);

}  // namespace shaker::footage
