#pragma once
// The table that a measurement program prints: aligned text, or with --json the same rows as an array of
// objects.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
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
    void print(int argc, char** argv) const {
        bool json = false;
        for (int i = 1; i < argc; ++i) json = json || std::strcmp(argv[i], "--json") == 0;
        std::fputs((json ? as_json() : as_text()).c_str(), stdout);
    }

    [[nodiscard]] std::string as_json() const {
        nlohmann::ordered_json array = nlohmann::ordered_json::array();
        for (const Row& row : rows_) {
            nlohmann::ordered_json object;
            for (const Cell& cell : row)
                std::visit([&](const auto& value) { object[cell.heading()] = value; }, cell.value);
            array.push_back(object);
        }
        return array.dump(1) + "\n";
    }

    [[nodiscard]] std::string as_text() const {
        const std::vector<std::string> columns = headings();
        std::vector<std::size_t> widths;
        for (const std::string& column : columns) {
            widths.push_back(column.size());
            for (const Row& row : rows_) widths.back() = std::max(widths.back(), text_of(row, column).size());
        }
        std::string out;
        const auto line = [&](const auto& text_in) {
            for (std::size_t i = 0; i < columns.size(); ++i) {
                const std::string text = text_in(columns[i]);
                const std::string gap(widths[i] - text.size(), ' ');
                out += (i > 0 ? "  " : "") + (is_words(columns[i]) ? text + gap : gap + text);
            }
            out.erase(out.find_last_not_of(' ') + 1);
            out += '\n';
        };
        line([](const std::string& column) { return column; });
        for (const Row& row : rows_) line([&](const std::string& column) { return text_of(row, column); });
        return out;
    }

private:
    [[nodiscard]] std::vector<std::string> headings() const {
        std::vector<std::string> found;
        for (const Row& row : rows_)
            for (const Cell& cell : row)
                if (std::find(found.begin(), found.end(), cell.heading()) == found.end())
                    found.push_back(cell.heading());
        return found;
    }
    [[nodiscard]] static const Cell* find(const Row& row, const std::string& column) {
        for (const Cell& cell : row)
            if (cell.heading() == column) return &cell;
        return nullptr;
    }
    [[nodiscard]] static std::string text_of(const Row& row, const std::string& column) {
        const Cell* cell = find(row, column);
        return cell ? cell->text() : "-";
    }
    [[nodiscard]] bool is_words(const std::string& column) const {
        for (const Row& row : rows_)
            if (const Cell* cell = find(row, column)) return std::holds_alternative<std::string>(cell->value);
        return false;
    }

    std::vector<Row> rows_;
};

}  // namespace shaker::bench
