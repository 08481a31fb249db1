#include "drivers/footage/csv.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>

#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"

namespace shaker::footage {
namespace {

constexpr std::size_t first_row_line = 2;

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

void split(std::string_view line, std::vector<std::string_view>& fields) {
    fields.clear();
    while (true) {
        const auto comma = line.find(',');
        fields.push_back(trimmed(line.substr(0, comma)));
        if (comma == std::string_view::npos) return;
        line.remove_prefix(comma + 1);
    }
}

std::vector<std::string> header_of(std::string_view line) {
    if (line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
    std::vector<std::string_view> fields;
    split(line, fields);
    std::vector<std::string> names;
    for (auto field : fields) {
        const bool quoted = field.size() >= 2 && field.front() == '"' && field.back() == '"';
        names.emplace_back(quoted ? field.substr(1, field.size() - 2) : field);
    }
    return names;
}

std::string in_quotes(std::string_view text) {
    std::string quoted{'"'};
    quoted.append(text).push_back('"');
    return quoted;
}

std::size_t column_of(const std::string& name, const std::vector<std::string>& header,
                      const std::string& file) {
    const auto count = std::count(header.begin(), header.end(), name);
    if (count == 1)
        return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
    std::string there;
    for (const auto& word : header) there += (there.empty() ? "" : ", ") + in_quotes(word);
    throw InputError{file + ":1: column " + in_quotes(name) +
                     (count == 0 ? " is missing" : " is present " + std::to_string(count) + " times") +
                     "; the columns are " + there};
}

std::optional<double> finite_number(std::string_view field) {
    if (field.starts_with('+') && !field.starts_with("+-")) field.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc{} || end != field.data() + field.size() || !std::isfinite(value)) return {};
    return value;
}

}  // namespace

std::string CsvColumns::where(std::size_t row) const {
    return file.string() + ":" + std::to_string(row + first_row_line);
}

CsvColumns read_csv(const std::filesystem::path& file, std::span<const std::string> names) {
    const std::string name = file.string();
    if (std::filesystem::is_directory(file)) throw InputError{name + ": is a folder, not a table"};
    std::ifstream in{file, std::ios::binary};
    if (!in) throw InputError{name + ": cannot be opened: " + std::strerror(errno)};
    std::string line;
    if (!std::getline(in, line)) throw InputError{name + ": is empty; expected a header row"};
    const std::vector<std::string> header = header_of(line);

    CsvColumns table{file, {names.begin(), names.end()}, std::vector<std::vector<double>>(names.size())};
    std::vector<std::size_t> columns;
    for (const auto& wanted : names) columns.push_back(column_of(wanted, header, name));

    std::vector<std::string_view> fields;
    std::size_t blank_lines = 0;
    for (std::size_t row = 0; std::getline(in, line);) {
        if (trimmed(line).empty()) {
            ++blank_lines;
            continue;
        }
        if (blank_lines > 0) throw InputError{table.where(row) + ": blank row in the middle of the table"};
        split(line, fields);
        if (fields.size() != header.size())
            throw InputError{table.where(row) + ": this row has " + std::to_string(fields.size()) +
                             " fields, the header has " + std::to_string(header.size())};
        for (std::size_t i = 0; i < columns.size(); ++i) {
            const auto value = finite_number(fields[columns[i]]);
            if (!value)
                throw InputError{table.where(row) + ": column " + in_quotes(names[i]) + ": " +
                                 in_quotes(fields[columns[i]]) + " is not a finite number"};
            table.values[i].push_back(*value);
        }
        ++row;
    }
    if (in.bad()) throw DeviceError{name + ": cannot be read: " + std::strerror(errno)};
    if (table.values.front().empty()) throw InputError{name + ": has a header but no rows"};
    return table;
}

void require_increasing(const CsvColumns& table) {
    const auto& t = table.values.front();
    for (std::size_t row = 1; row < t.size(); ++row)
        if (!(t[row] > t[row - 1]))
            throw InputError{table.where(row) + ": column " + in_quotes(table.names.front()) +
                             " must increase from row to row, but " + to_text(t[row]) + " follows " +
                             to_text(t[row - 1])};
}

}  // namespace shaker::footage
