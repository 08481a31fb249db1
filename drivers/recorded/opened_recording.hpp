#pragma once
// Internal state of a RecordingReader, for the classes that read streams from the same file, and their
// reading of rows (raw_columns.hpp). Every error is an InputError with the path inside the file.
#include <vector>

#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/raw_columns.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recorded {

struct RecordingReader::Opened {
    std::filesystem::path path;
    h5::Handle file, entry;
    RecordingHeader header;
};

/// The numbers of a column as they are in memory. Refuses those outside the column's range.
std::vector<std::byte> read_values(hid_t entry, const RawColumn& column, const std::string& path);
/// InputError when a column has not the expected number of values.
void require_length(std::size_t values, std::size_t expected, const std::string& path);

/// All rows of a stream. camera: whose frames.
template <class Row>
std::vector<Row> read_rows(hid_t entry, std::span<const RawColumnOf<Row>> columns,
                           const std::string& camera = {}) {
    std::vector<Row> rows;
    for (const auto& column : columns) {
        const std::string path = path_of(column, camera);
        if (column.added_later && !h5::exists(entry, path)) continue;
        const std::vector<std::byte> values = read_values(entry, column, path);
        const std::size_t width = column.bytes();
        if (&column == &columns.front()) rows.resize(values.size() / width);
        require_length(values.size() / (width / column.values), column.values * rows.size(), path);
        for (std::size_t i = 0; i < rows.size(); ++i) column.set(rows[i], values.data() + i * width);
    }
    return rows;
}

}  // namespace shaker::recorded
