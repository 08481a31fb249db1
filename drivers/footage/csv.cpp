#include "drivers/footage/csv.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>

#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"

namespace shaker::footage {

namespace {

constexpr std::string_view separators = ",;\t";
constexpr std::size_t most_lines_above = 200;  // of the heading
constexpr std::size_t most_told = 200;         // bytes of somebody's file in a message
constexpr std::size_t most_columns_told = 10;

std::string in_quotes(std::string_view text) {
    const bool cut = text.size() > most_told / 2;
    return "\"" + std::string{text.substr(0, most_told / 2)} + (cut ? "...\"" : "\"");
}

void add_utf8(std::string& text, std::uint32_t code) {
    const auto add = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
    if (code < 0x80) return add(code);
    if (code < 0x800) {
        add(0xC0 | code >> 6U);
    } else {
        add(0xE0 | code >> 12U);
        add(0x80 | (code >> 6U & 0x3FU));
    }
    add(0x80 | (code & 0x3FU));
}

/// UTF-16 after its mark, as UTF-8. Pairs of surrogates stay in pieces: numbers have none.
std::string from_utf16(std::string_view bytes, bool big_endian) {
    std::string text;
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
        const auto first = static_cast<unsigned char>(bytes[i]),
                   second = static_cast<unsigned char>(bytes[i + 1]);
        add_utf8(text, big_endian ? first * 256U + second : second * 256U + first);
    }
    return text;
}

std::string text_of(const std::filesystem::path& file) {
    const std::string name = file.string();
    if (std::filesystem::is_directory(file)) throw InputError{name + ": is a folder, not a table"};
    std::ifstream in{file, std::ios::binary};
    if (!in) throw InputError{name + ": cannot be opened: " + std::strerror(errno)};
    std::string text{std::istreambuf_iterator<char>{in}, {}};
    if (in.bad()) throw DeviceError{name + ": cannot be read: " + std::strerror(errno)};
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
        text = from_utf16(std::string_view{text}.substr(2), text.starts_with("\xFE\xFF"));
    if (text.empty()) throw InputError{name + ": is empty; expected a header row"};
    const auto control = [](char c) { return c >= 0 && c < ' ' && c != '\t' && c != '\r' && c != '\n'; };
    if (std::ranges::any_of(text.substr(0, 4096), control))
        throw InputError{name + ": is a binary file; expected a text table"};
    return text;
}

/// Lines end with CR LF, LF, or CR in a file without LF.
std::vector<std::string_view> lines_of(std::string_view text) {
    const char end = text.find('\n') != std::string_view::npos ? '\n' : '\r';
    std::vector<std::string_view> lines;
    while (!text.empty()) {
        const std::size_t length = std::min(text.find(end), text.size());
        lines.push_back(text.substr(0, length));
        text.remove_prefix(std::min(length + 1, text.size()));
    }
    while (!lines.empty() && trimmed(lines.back()).empty()) lines.pop_back();
    return lines;
}

/// A field in quotes may contain the separator, and quotes that are doubled.
void split(std::string_view line, char separator, std::vector<std::string>& fields) {
    fields.clear();
    line = trimmed(line).size() > 0 ? line : std::string_view{};
    if (line.ends_with('\r')) line.remove_suffix(1);
    for (bool more = true; more;) {
        std::string field;
        const std::size_t quote = line.find_first_not_of(separator == '\t' ? " " : " \t");
        if (quote != std::string_view::npos && line[quote] == '"') {
            line.remove_prefix(quote + 1);
            while (!line.empty()) {
                const bool is_quote = line.front() == '"',
                           doubled = is_quote && line.substr(1).starts_with('"');
                line.remove_prefix(doubled ? 2 : is_quote ? 1 : 0);
                if (is_quote && !doubled) break;
                field += is_quote ? '"' : line.front();
                if (!is_quote) line.remove_prefix(1);
            }
        }
        const std::size_t end = std::min(line.find(separator), line.size());
        fields.push_back(field + std::string{trimmed(line.substr(0, end))});
        more = end < line.size();
        line.remove_prefix(std::min(end + 1, line.size()));
    }
}

std::optional<double> finite_number(std::string field, char separator) {
    if (separator != ',' && field.find('.') == std::string::npos)
        if (const std::size_t comma = field.find(','); comma != std::string::npos) field[comma] = '.';
    std::string_view digits{field};
    if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value)) return {};
    return value;
}

struct Heading {
    std::size_t line = 0;
    char separator = ',';
    std::vector<std::string> names{};
};

[[noreturn]] void fail_heading(const std::string& where, const std::string& name, const Heading& heading) {
    const auto count = std::ranges::count(heading.names, name);
    std::string there;
    for (std::size_t i = 0; i < std::min(heading.names.size(), most_columns_told); ++i)
        there += (i == 0 ? "" : ", ") + in_quotes(heading.names[i]);
    if (there.size() > most_told)
        there = there.substr(0, most_told) + "...";
    else if (heading.names.size() > most_columns_told)
        there += ", ...";
    throw InputError{where + ": column " + in_quotes(name) +
                     (count == 0 ? " is missing" : " is present " + std::to_string(count) + " times") +
                     "; the columns are " + there};
}

/// The first line with all names; otherwise the first that is no comment, so that it can be shown.
Heading heading_of(const std::vector<std::string_view>& lines, std::span<const std::string> names) {
    std::optional<Heading> first;
    for (std::size_t i = 0; i < std::min(lines.size(), most_lines_above); ++i) {
        if (trimmed(lines[i]).starts_with('#') || trimmed(lines[i]).empty()) continue;
        std::optional<Heading> best;
        for (const char separator : separators) {
            Heading here{.line = i, .separator = separator};
            split(lines[i], separator, here.names);
            const auto has = [&](const std::string& name) {
                return std::ranges::find(here.names, name) != here.names.end();
            };
            if (std::ranges::all_of(names, has) && (!best || here.names.size() > best->names.size()))
                best = here;
            if (!first || (first->line == i && here.names.size() > first->names.size())) first = here;
        }
        if (best) return *best;
    }
    return first.value_or(Heading{});
}

}  // namespace

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

const CsvUnit* unit_in(std::string_view text) noexcept {
    static constexpr std::array units = std::to_array<CsvUnit>({{"s", 1, true},
                                                                {"sec", 1, true},
                                                                {"ms", 1e-3, true},
                                                                {"us", 1e-6, true},
                                                                {"\xC2\xB5s", 1e-6, true},
                                                                {"ns", 1e-9, true},
                                                                {"g", 9.80665, false},
                                                                {"mg", 9.80665e-3, false},
                                                                {"mps2", 1, false},
                                                                {"m/s^2", 1, false},
                                                                {"m/s2", 1, false},
                                                                {"m/s**2", 1, false},
                                                                {"m/s\xC2\xB2", 1, false},
                                                                {"mm/s^2", 1e-3, false}});
    text = trimmed(text);
    for (const std::string_view pair : {"()", "[]"})
        if (const auto open = text.rfind(pair[0]); open != std::string_view::npos && text.ends_with(pair[1]))
            text = text.substr(open + 1, text.size() - open - 2);
    const auto found = std::ranges::find(units, trimmed(text), &CsvUnit::word);
    return found == units.end() ? nullptr : &*found;
}

std::string CsvColumns::where(std::size_t row) const {
    return file.string() + ":" + std::to_string(row + first_line);
}

CsvColumns read_csv(const std::filesystem::path& file, std::span<const std::string> names) {
    const std::string text = text_of(file);
    const std::vector<std::string_view> lines = lines_of(text);
    const Heading heading = heading_of(lines, names);
    CsvColumns table{
        file, {names.begin(), names.end()}, std::vector<std::vector<double>>(names.size()), {}, 0};
    std::vector<std::size_t> columns;
    for (const std::string& name : names) {
        if (std::ranges::count(heading.names, name) != 1)
            fail_heading(file.string() + ":" + std::to_string(heading.line + 1), name, heading);
        columns.push_back(
            static_cast<std::size_t>(std::ranges::find(heading.names, name) - heading.names.begin()));
    }
    std::vector<std::string> fields;
    std::size_t next = heading.line + 1;
    table.first_line = next + 1;
    if (next < lines.size()) {
        split(lines[next], heading.separator, fields);
        const auto is_unit = [&](std::size_t c) { return unit_in(fields[c]) != nullptr; };
        if (fields.size() == heading.names.size() && std::ranges::all_of(columns, is_unit)) {
            for (const std::size_t c : columns) table.units.push_back(fields[c]);
            ++next;
            ++table.first_line;
        }
    }
    for (; next < lines.size(); ++next) {
        const std::size_t row = table.values.front().size();
        const std::string_view line = lines[next];
        if (trimmed(line).empty())
            throw InputError{table.where(row) + ": blank row in the middle of the table"};
        split(line, heading.separator, fields);
        if (fields.size() != heading.names.size())
            throw InputError{table.where(row) + ": this row has " + std::to_string(fields.size()) +
                             " fields, the header has " + std::to_string(heading.names.size())};
        for (std::size_t i = 0; i < columns.size(); ++i) {
            const auto value = finite_number(fields[columns[i]], heading.separator);
            if (!value)
                throw InputError{table.where(row) + ": column " + in_quotes(names[i]) + ": " +
                                 in_quotes(fields[columns[i]]) + " is not a finite number"};
            table.values[i].push_back(*value);
        }
    }
    if (table.values.front().empty()) throw InputError{file.string() + ": has a header but no rows"};
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
