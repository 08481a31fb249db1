#pragma once
// A recording as tables for other programs.
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "drivers/recorded/recording_file.hpp"

namespace shaker::exporting {

struct ExportColumn {
    std::string name;
    std::string units;  // UDUNITS text; empty for texts
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>> values;
};

/// A table that is read in pieces.
struct ExportTable {
    std::string name;  // "tracks/top/walker"
    /// Without values; each piece has the same number of rows in all columns.
    std::vector<ExportColumn> columns;
    /// Replaces the values by those of the next rows; false at the end. InputError for errors of the file.
    std::function<bool(std::vector<ExportColumn>&)> next;
};

std::size_t rows_of(const std::vector<ExportColumn>& columns);

/// All tables of a recording. The file must outlive them.
std::vector<ExportTable> export_tables(const recorded::RecordingReader& file);

/// The tables whose name starts with one of `what`; "all" is every table except "drive". InputError, with the
/// list of valid words, for a word that matches no table. file: named in the message.
std::vector<ExportTable> chosen(std::vector<ExportTable> tables, const std::vector<std::string>& what,
                                const std::filesystem::path& file);

}  // namespace shaker::exporting
