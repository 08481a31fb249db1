#pragma once
// A recording as tables for other people's tools.
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "drivers/replay/session_file.hpp"

namespace shaker {

struct ExportColumn {
    std::string name;
    std::string units;  // UDUNITS text; of texts: empty
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>> values;
};

/// A table that is read piece by piece.
struct ExportTable {
    std::string name;                   // "tracks/top/walker"
    std::vector<ExportColumn> columns;  // without values; all get equally many rows
    /// Puts the next rows in place of those that are there; false when there are no more. InputError for what
    /// is wrong with the file.
    std::function<bool(std::vector<ExportColumn>&)> next;
};

std::size_t rows_of(const std::vector<ExportColumn>& columns);

/// Those that are named by the first part of their name; "all": every one but "drive". InputError, with the
/// words that would do, for a word that names none. The file outlives the tables.
std::vector<ExportTable> export_tables(const SessionReader& file, const std::vector<std::string>& what);

}  // namespace shaker
