#include "tests/bench/table.hpp"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

namespace shaker::bench {

namespace {

std::vector<std::string> headings_of(const std::vector<Row>& rows) {
    std::vector<std::string> found;
    for (const Row& row : rows)
        for (const Cell& cell : row)
            if (std::find(found.begin(), found.end(), cell.heading()) == found.end())
                found.push_back(cell.heading());
    return found;
}

const Cell* find(const Row& row, const std::string& column) {
    for (const Cell& cell : row)
        if (cell.heading() == column) return &cell;
    return nullptr;
}

std::string text_of(const Row& row, const std::string& column) {
    const Cell* cell = find(row, column);
    return cell ? cell->text() : "-";
}

bool is_words(const std::vector<Row>& rows, const std::string& column) {
    for (const Row& row : rows)
        if (const Cell* cell = find(row, column)) return std::holds_alternative<std::string>(cell->value);
    return false;
}

}  // namespace

void Table::print(int argc, char** argv) const {
    bool json = false;
    for (int i = 1; i < argc; ++i) json = json || std::strcmp(argv[i], "--json") == 0;
    std::fputs((json ? as_json() : as_text()).c_str(), stdout);
}

std::string Table::as_json() const {
    nlohmann::ordered_json array = nlohmann::ordered_json::array();
    for (const Row& row : rows_) {
        nlohmann::ordered_json object;
        for (const Cell& cell : row)
            std::visit([&](const auto& value) { object[cell.heading()] = value; }, cell.value);
        array.push_back(object);
    }
    return array.dump(1) + "\n";
}

std::string Table::as_text() const {
    const std::vector<std::string> columns = headings_of(rows_);
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
            out += (i > 0 ? "  " : "") + (is_words(rows_, columns[i]) ? text + gap : gap + text);
        }
        out.erase(out.find_last_not_of(' ') + 1);
        out += '\n';
    };
    line([](const std::string& column) { return column; });
    for (const Row& row : rows_) line([&](const std::string& column) { return text_of(row, column); });
    return out;
}

}  // namespace shaker::bench
