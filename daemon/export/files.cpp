#include "daemon/export/files.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <iterator>
#include <memory>
#include <system_error>

#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"

namespace shaker::exporting {

namespace {

[[noreturn]] void refuse_existing(const std::filesystem::path& file) {
    throw InputError{file.string() + ": exists already; an export does not overwrite files"};
}

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
    throw DeviceError{file.string() + ": " + std::generic_category().message(error)};
}

std::string quoted(const std::string& text) {
    std::string out{'"'};
    for (const char c : text) out.append(c == '"' ? 2 : 1, c);
    return out + '"';
}

using Text = fmt::memory_buffer;

void append(Text& line, double value) { fmt::format_to(std::back_inserter(line), "{:.17g}", value); }
void append(Text& line, std::int64_t value) { fmt::format_to(std::back_inserter(line), "{}", value); }
void append(Text& line, const std::string& value) {
    fmt::format_to(std::back_inserter(line), "{}", quoted(value));
}

std::string heading_of(const ExportColumn& column) {
    return column.units.empty() ? column.name : column.name + " [" + column.units + "]";
}

void append_rows(Text& text, const std::vector<ExportColumn>& columns) {
    for (std::size_t row = 0; row < rows_of(columns); ++row)
        for (std::size_t c = 0; c < columns.size(); ++c) {
            std::visit([&](const auto& values) { append(text, values[row]); }, columns[c].values);
            text.push_back(c + 1 < columns.size() ? ',' : '\n');
        }
}

}  // namespace

NewFiles::NewFiles(std::filesystem::path folder, const std::vector<std::string>& names)
    : folder_{std::move(folder)} {
    for (const std::string& name : names)
        if (std::filesystem::exists(folder_ / name)) refuse_existing(folder_ / name);
    std::error_code error;
    if (std::filesystem::create_directories(folder_, error)) made_.push_back(folder_);
    if (error) throw InputError{folder_.string() + ": the folder cannot be created: " + error.message()};
}

NewFiles::~NewFiles() {
    std::error_code ignored;
    for (; !made_.empty(); made_.pop_back()) std::filesystem::remove(made_.back(), ignored);
}

std::filesystem::path NewFiles::make(const std::string& name) {
    std::filesystem::path file = folder_ / name;
    const Descriptor descriptor{::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)};
    if (descriptor < 0 && errno == EEXIST) refuse_existing(file);
    if (descriptor < 0) fail(file, errno);
    made_.push_back(file);
    return file;
}

std::string joined_name(const std::string& table) {
    std::string name = table;
    std::ranges::replace(name, '/', '-');
    return name;
}

std::size_t write_csv(ExportTable& table, const std::filesystem::path& file) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out{std::fopen(file.c_str(), "we"), &std::fclose};
    if (!out) fail(file, errno);
    Text text;
    for (const ExportColumn& c : table.columns) {
        const std::string heading = heading_of(c);
        text.append(heading);
        text.push_back(&c == &table.columns.back() ? '\n' : ',');
    }
    const auto put = [&] {
        if (std::fwrite(text.data(), 1, text.size(), out.get()) != text.size()) fail(file, errno);
        text.clear();
    };
    put();
    std::size_t rows = 0;
    while (table.next(table.columns)) {
        rows += rows_of(table.columns);
        append_rows(text, table.columns);
        put();
    }
    if (std::fflush(out.get()) != 0) fail(file, errno);
    return rows;
}

}  // namespace shaker::exporting
