#pragma once
// The table that a measurement program prints: aligned text, or with --json the same rows as an array of
// objects.
#include <array>
#include <cstdio>
#include <string>
#include <variant>
#include <vector>

namespace shaker::bench {

/// One value of a row. The heading of its column (and JSON key) is "name (unit)", or the name alone.
struct Cell {
    std::string name;
    std::variant<std::string, double> value;
    std::string unit = {};
    int digits = 3;  // significant digits in the text; JSON has all digits, and null for NaN and infinity

    [[nodiscard]] std::string heading() const { return unit.empty() ? name : name + " (" + unit + ")"; }
    [[nodiscard]] std::string text() const {
        if (const auto* words = std::get_if<std::string>(&value)) return *words;
        std::array<char, 64> buffer{};
        std::snprintf(buffer.data(), buffer.size(), "%.*g", digits, std::get<double>(value));
        return buffer.data();
    }
};
using Row = std::vector<Cell>;

/// Rows in the order of adding; a row may leave out columns, which are printed as "-".
class Table {
public:
    void add(Row row) { rows_.push_back(std::move(row)); }

    /// Prints to standard output: JSON if "--json" is among the arguments of the program, otherwise text.
    void print(int argc, char** argv) const;
    [[nodiscard]] std::string as_json() const;
    [[nodiscard]] std::string as_text() const;

private:
    std::vector<Row> rows_;
};

}  // namespace shaker::bench
