#pragma once
// Columns of a recording's tables. Each table has one constexpr list with the name, unit, member and meaning
// of its columns; writing, reading, comparing, exporting and FORMAT.md go through that list.
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <ranges>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "drivers/recorded/recording_file.hpp"
#include "drivers/time.hpp"

namespace shaker::recording {

/// A column of numbers: one number per Row.
template <class Row>
struct NumberColumn {
    const char* name;
    const char* units;  // UDUNITS text
    const char* meaning;
    double (*get)(const Row&);
    /// Stores a number from a file in a row; false when the member cannot have that value. Null: the column
    /// is derived from other members and is not read.
    bool (*set)(Row&, double) = nullptr;
    bool provisional = false;  // replaced when the recording is completed, and therefore not sealed
};

/// A column of texts: one text per Row.
template <class Row>
struct TextColumn {
    const char* name;
    std::size_t bytes;  // length of the longest text
    const char* meaning;
    std::string (*get)(const Row&);
    bool (*set)(Row&, const std::string&) = nullptr;
};

/// Default plot of a table in NeXus programs. Null signal: no plot.
struct Plot {
    const char* signal = nullptr;
    const char* axes = nullptr;
    const char* title = nullptr;
};

/// A table, or single numbers and texts of one Row. Path and meaning belong to the whole group.
template <class Row>
struct Table {
    const char* path;  // under /entry
    const char* meaning;
    std::span<const NumberColumn<Row>> numbers;
    std::span<const TextColumn<Row>> texts{};
    Plot plot{};
};

constexpr std::size_t word_bytes = 32, sentence_bytes = 512;  // longest texts of two kinds

namespace columns {

template <class T>
double number_of(const T& value) {
    if constexpr (std::same_as<T, MasterTime>)
        return seconds(value);
    else
        return static_cast<double>(value);
}

/// Converts a number. False when the type of `to` does not have this value: integers, enumerators and flags
/// need a whole number that a double represents exactly.
template <class T>
bool take(T& to, double value) {
    if constexpr (std::same_as<T, MasterTime>) {
        to = master_time(value);
    } else if constexpr (std::floating_point<T>) {
        to = value;
    } else {
        constexpr double exact = 9e15;
        const double most = sizeof(T) < 8 ? std::numeric_limits<std::int32_t>::max() : exact;
        const bool negative = std::signbit(value) && value != 0;
        if (!(std::abs(value) <= most && value == std::floor(value))) return false;
        if (std::is_unsigned_v<T> && negative) return false;
        to = static_cast<T>(static_cast<std::int64_t>(value));
    }
    return true;
}

template <class Member>
struct ClassOf;
template <class Class, class Member>
struct ClassOf<Member Class::*> {
    using type = Class;
};

}  // namespace columns

/// Column of a member or of a member's member: number<&Track::fix, &Fix::x_px>("x_px", "px", ...).
template <auto First, auto... Rest>
constexpr auto number(const char* name, const char* units, const char* meaning, bool provisional = false) {
    using Row = typename columns::ClassOf<decltype(First)>::type;
    return NumberColumn<Row>{
        name,
        units,
        meaning,
        [](const Row& row) { return columns::number_of(((row.*First).*....*Rest)); },
        [](Row& row, double value) { return columns::take(((row.*First).*....*Rest), value); },
        provisional};
}

/// Column of a text member.
template <auto First, auto... Rest>
constexpr auto text(const char* name, std::size_t bytes, const char* meaning) {
    using Row = typename columns::ClassOf<decltype(First)>::type;
    return TextColumn<Row>{name, bytes, meaning,
                           [](const Row& row) -> std::string { return ((row.*First).*....*Rest); },
                           [](Row& row, const std::string& value) {
                               ((row.*First).*....*Rest) = value;
                               return true;
                           }};
}

/// A number of a recording: its path under /entry, its value, its unit.
struct RecordedNumber {
    std::string path;
    double value;
    std::string units;
};

/// A table of a recording: its path under /entry and its columns.
struct RecordedTable {
    std::string path;
    std::vector<recorded::Column> columns;
};

/// The numbers of one row, in the order of the columns.
template <class Row>
std::vector<double> row_of(const Table<Row>& table, const Row& row) {
    std::vector<double> values;
    values.reserve(table.numbers.size());
    for (const NumberColumn<Row>& c : table.numbers) values.push_back(c.get(row));
    return values;
}

/// The number columns of `rows` as a table. path: overrides the table's own path.
template <class Row, std::ranges::input_range Rows>
RecordedTable table_of(const Table<Row>& table, const Rows& rows, const std::string& path = {}) {
    RecordedTable out{path.empty() ? table.path : path, {}};
    for (const NumberColumn<Row>& c : table.numbers) {
        recorded::Column& column = out.columns.emplace_back(recorded::Column{c.name, c.units, {}});
        column.values.reserve(std::ranges::size(rows));
        for (const Row& row : rows) column.values.push_back(c.get(row));
    }
    return out;
}

/// Single numbers of one Row, each under its own path.
template <class Row>
std::vector<RecordedNumber> numbers_of(const Table<Row>& table, const Row& row,
                                       const std::string& path = {}) {
    std::vector<RecordedNumber> out;
    for (const NumberColumn<Row>& c : table.numbers)
        out.push_back({(path.empty() ? table.path : path) + "/" + c.name, c.get(row), c.units});
    return out;
}

void write(recorded::RecordingWriter& file, const std::vector<RecordedNumber>& numbers);
void write(recorded::RecordingWriter& file, const std::vector<RecordedTable>& tables);
/// Appends rows, numbers and texts.
template <class Row, std::ranges::input_range Rows>
void write_rows(recorded::RecordingWriter& file, const Table<Row>& table, const Rows& rows) {
    if (!table.numbers.empty()) write(file, {table_of(table, rows)});
    for (const TextColumn<Row>& c : table.texts) {
        std::vector<std::string> texts;
        for (const Row& row : rows) texts.push_back(c.get(row));
        file.texts(std::string{table.path} + "/" + c.name, texts);
    }
}

[[noreturn]] void refuse_length(const std::string& path, const char* name, std::size_t rows,
                                const char* first, std::size_t expected);
[[noreturn]] void refuse_value(const std::string& path, const char* name, std::size_t row,
                               const std::string& value);

/// Reads rows of a file with the functions numbers(path) and texts(path); columns without a setter are not
/// read. InputError naming a column that is missing, differs in length from the first one, or has a value
/// that its member cannot have.
template <class File, class Row>
std::vector<Row> read_rows(const File& file, const Table<Row>& table, const std::string& at = {}) {
    const std::string path = at.empty() ? table.path : at;
    std::vector<Row> rows;
    const char* first = nullptr;
    const auto fill = [&](const auto& column, const auto& values, const auto& word) {
        if (first == nullptr) {
            first = column.name;
            rows.resize(values.size());
        }
        if (values.size() != rows.size()) refuse_length(path, column.name, values.size(), first, rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i)
            if (!column.set(rows[i], values[i])) refuse_value(path, column.name, i, word(values[i]));
    };
    for (const TextColumn<Row>& c : table.texts)
        if (c.set != nullptr)
            fill(c, file.texts(path + "/" + c.name), [](const std::string& s) { return '"' + s + '"'; });
    for (const NumberColumn<Row>& c : table.numbers)
        if (c.set != nullptr)
            fill(c, file.numbers(path + "/" + c.name), [](double v) { return std::to_string(v); });
    return rows;
}

/// Reads rows `first` to `first + count` of a table that is being written; only its numbers. InputError as
/// above, DeviceError when the disk fails.
template <class Row>
std::vector<Row> read_rows(recorded::RecordingWriter& file, const Table<Row>& table, const std::string& path,
                           std::size_t first, std::size_t count) {
    std::vector<Row> rows(count);
    for (const NumberColumn<Row>& c : table.numbers) {
        if (c.set == nullptr) continue;
        const std::vector<double> values = file.numbers(path + "/" + c.name, first, count);
        for (std::size_t i = 0; i < count; ++i)
            if (!c.set(rows[i], values[i])) refuse_value(path, c.name, first + i, std::to_string(values[i]));
    }
    return rows;
}

/// Places of a table's columns. path: overrides the table's own path.
template <class Row>
recorded::GroupLayout layout_of(const Table<Row>& table, const std::string& path = {}, double rows_per_s = 0,
                                bool single = false) {
    using Kind = recorded::Place::Kind;
    recorded::GroupLayout layout{path.empty() ? table.path : path,
                                 table.plot.signal != nullptr ? "NXdata" : "NXcollection",
                                 {},
                                 {},
                                 rows_per_s,
                                 table.meaning};
    for (const auto& [key, text] : {std::pair{"signal", table.plot.signal},
                                    std::pair{"axes", table.plot.axes}, std::pair{"title", table.plot.title}})
        if (text != nullptr) layout.attributes[key] = text;
    for (const NumberColumn<Row>& c : table.numbers)
        layout.places.push_back(
            {c.name, c.units, single ? Kind::number : Kind::numbers, 0, c.provisional, c.meaning});
    for (const TextColumn<Row>& c : table.texts)
        layout.places.push_back({c.name, "", single ? Kind::text : Kind::texts, c.bytes, false, c.meaning});
    return layout;
}

/// Places of the single numbers and texts of one Row.
template <class Row>
recorded::GroupLayout places_of(const Table<Row>& table, const std::string& path = {}) {
    return layout_of(table, path, 0, true);
}

}  // namespace shaker::recording
