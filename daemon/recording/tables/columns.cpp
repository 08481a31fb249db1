#include "daemon/recording/tables/columns.hpp"

#include <spdlog/fmt/fmt.h>

#include "drivers/errors.hpp"

namespace shaker::recording {

void write(recorded::RecordingWriter& file, const std::vector<RecordedNumber>& numbers) {
    for (const RecordedNumber& n : numbers) file.scalar(n.path, n.value);
}

void write(recorded::RecordingWriter& file, const std::vector<RecordedTable>& tables) {
    for (const RecordedTable& t : tables) file.rows(t.path, t.columns);
}

void refuse_length(const std::string& path, const char* name, std::size_t rows, const char* first,
                   std::size_t expected) {
    throw InputError{
        fmt::format("recording: {0}/{1} has {2} rows, {0}/{3} has {4}", path, name, rows, first, expected)};
}

void refuse_value(const std::string& path, const char* name, std::size_t row, const std::string& value) {
    throw InputError{
        fmt::format("recording: {}/{} row {}: {} is not a value of this column", path, name, row, value)};
}

}  // namespace shaker::recording
