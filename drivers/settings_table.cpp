#include "drivers/settings_table.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

std::string shown(const toml::node& node) {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    node.visit([&](const auto& value) { out << value; });
    std::string text = out.str();
    std::replace(text.begin(), text.end(), '\n', ' ');
    constexpr std::size_t longest = 80;
    if (text.size() > longest) text.replace(longest, std::string::npos, "...");
    return text;
}

std::string quoted_list(const std::vector<std::string>& words) {
    std::string list;
    for (const auto& word : words) list += (list.empty() ? "\"" : ", \"") + word + "\"";
    return list;
}

/// Letters left out, added, replaced, or exchanged with their neighbours.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> above(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 0; i < a.size(); ++i) {
        next[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            next[j + 1] = std::min({row[j] + (a[i] == b[j] ? 0 : 1), row[j + 1] + 1, next[j] + 1});
            if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j])
                next[j + 1] = std::min(next[j + 1], above[j - 1] + 1);
        }
        above.swap(row);
        row.swap(next);
    }
    return row.back();
}

/// The known key closest to `key`: for typing errors or a missing unit ("gamma" for "gamma_mps2").
std::string nearest(std::string_view key, const std::set<std::string, std::less<>>& known) {
    std::size_t best = std::max<std::size_t>(2, key.size() / 3) + 1;
    std::string found;
    for (const auto& word : known) {
        const bool unit_left_out = word.starts_with(std::string{key} + "_");
        const std::size_t distance = unit_left_out ? 0 : edit_distance(key, word);
        if (distance < best) best = distance, found = word;
    }
    return found;
}

constexpr std::streamsize most_checked = 4096;  // bytes

std::string read_all(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    if (std::filesystem::is_directory(file))
        throw InputError{file.string() + ": is a folder, not a settings file"};
    if (!in) throw InputError{file.string() + ": cannot be opened: " + std::strerror(errno)};
    std::string begin(most_checked, 0);
    in.read(begin.data(), most_checked);
    begin.resize(static_cast<std::size_t>(in.gcount()));
    if (begin.starts_with("\x89HDF\r\n"))
        throw InputError{file.string() +
                         ": is an HDF5 file, for example a recording; expected settings as text (TOML)"};
    if (begin.find('\0') != std::string::npos)
        throw InputError{file.string() + ": is a binary file; expected settings as text (TOML)"};
    in.clear();
    std::ostringstream text;
    text << begin;
    if (begin.size() == most_checked) text << in.rdbuf();
    return text.str();
}

}  // namespace

struct SettingsTable::Impl {
    std::shared_ptr<const toml::table> root;  // owns every node
    const toml::table* here = nullptr;        // null: a sub-table that is not in the file
    std::string file;
    std::string prefix;  // "camera.target." before the key in messages
    std::size_t line = 1;
    std::set<std::string, std::less<>> known;

    const toml::node* find(std::string_view key) {
        known.emplace(key);
        return here != nullptr ? here->get(key) : nullptr;
    }
    [[nodiscard]] std::size_t line_of(std::string_view key) const {
        if (here != nullptr)
            for (const auto& [name, node] : *here)
                if (name.str() == key) return name.source().begin.line;
        return line;
    }
    [[nodiscard]] std::string place(std::size_t its_line) const {
        return file + ":" + std::to_string(its_line) + ": ";
    }
    [[noreturn]] void fail(std::string_view key, const std::string& why) const {
        const std::string table = prefix.empty() ? "" : prefix.substr(0, prefix.size() - 1) + ": ";
        throw InputError{place(line_of(key)) + (key.empty() ? table : prefix + std::string{key} + ": ") +
                         why};
    }
    [[noreturn]] void wrong(std::string_view key, const toml::node& node, const std::string& expected) const {
        throw InputError{place(node.source().begin.line) + prefix + std::string{key} + ": expected " +
                         expected + ", got " + shown(node)};
    }
    const toml::node& need(std::string_view key, const std::string& expected) {
        const toml::node* node = find(key);
        if (node == nullptr) fail(key, "missing; expected " + expected);
        return *node;
    }
    double number(std::string_view key, const toml::node& node, Range allowed) const {
        const std::string expected = "a number, " + to_text(allowed);
        if (!node.is_number()) wrong(key, node, expected);
        const double value = *node.value<double>();
        if (!std::isfinite(value) || value < allowed.min || value > allowed.max) wrong(key, node, expected);
        return value;
    }
    double quantity(std::string_view key, const toml::node& node, Dimension dimension, Range allowed) const {
        if (!node.is_string()) return number(key, node, allowed);
        try {
            return parse_quantity(prefix + std::string{key}, node.as_string()->get(), dimension, allowed);
        } catch (const InputError& error) {
            throw InputError{place(node.source().begin.line) + error.what()};
        }
    }
    std::vector<SettingsTable> tables(std::string_view key, const toml::node& node) const {
        const std::string expected = "tables [[" + prefix + std::string{key} + "]]";
        if (!node.is_array()) wrong(key, node, expected);
        std::vector<SettingsTable> result;
        for (const toml::node& element : *node.as_array()) {
            if (!element.is_table()) wrong(key, element, expected);
            result.push_back(SettingsTable{child(key, element.as_table())});
        }
        return result;
    }
    std::string text(std::string_view key, const toml::node& node) const {
        if (!node.is_string()) wrong(key, node, "a string in quotes");
        return node.as_string()->get();
    }
    const toml::array& array(std::string_view key, std::size_t least, std::size_t most,
                             const std::string& of_what) {
        std::string expected = "an array of " + std::to_string(least);
        expected.append(most > least ? " to " + std::to_string(most) : "").append(" ").append(of_what);
        const toml::node& node = need(key, expected);
        const std::size_t count = node.is_array() ? node.as_array()->size() : 0;
        if (!node.is_array() || count < least || count > most) wrong(key, node, expected);
        return *node.as_array();
    }
    [[nodiscard]] std::unique_ptr<Impl> child(std::string_view key, const toml::table* table) const {
        const std::size_t its_line = table != nullptr ? table->source().begin.line : line;
        return std::make_unique<Impl>(Impl{root, table, file, prefix + std::string{key} + ".", its_line, {}});
    }
};

SettingsTable::SettingsTable(std::unique_ptr<Impl> impl) : impl_{std::move(impl)} {}
SettingsTable::SettingsTable(SettingsTable&&) noexcept = default;
SettingsTable& SettingsTable::operator=(SettingsTable&&) noexcept = default;
SettingsTable::~SettingsTable() = default;

SettingsTable SettingsTable::from_file(const std::filesystem::path& file) {
    return from_text(read_all(file), file.string());
}

SettingsTable SettingsTable::from_text(std::string_view text, std::string file_name) {
    try {
        auto root = std::make_shared<const toml::table>(toml::parse(text, file_name));
        const toml::table* here = root.get();
        return SettingsTable{
            std::make_unique<Impl>(Impl{std::move(root), here, std::move(file_name), "", 1, {}})};
    } catch (const toml::parse_error& error) {
        const auto at = error.source().begin;
        throw InputError{file_name + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " +
                         std::string{error.description()}};
    }
}

bool SettingsTable::has(std::string_view key) const { return impl_->find(key) != nullptr; }

bool SettingsTable::is_text(std::string_view key) const {
    const toml::node* node = impl_->find(key);
    return node != nullptr && node->is_string();
}

bool SettingsTable::is_table(std::string_view key) const {
    const toml::node* node = impl_->find(key);
    return node != nullptr && node->is_table();
}

std::size_t SettingsTable::line(std::string_view key) const { return impl_->line_of(key); }

double SettingsTable::quantity(std::string_view key, Dimension dimension, Range allowed) {
    return impl_->quantity(key, impl_->need(key, "a quantity, " + to_text(allowed)), dimension, allowed);
}

double SettingsTable::quantity(std::string_view key, Dimension dimension, Range allowed, double otherwise) {
    return has(key) ? quantity(key, dimension, allowed) : otherwise;
}

std::vector<double> SettingsTable::quantities(std::string_view key, Dimension dimension, Range allowed) {
    const toml::node& node = impl_->need(key, "a quantity or an array of quantities, " + to_text(allowed));
    if (!node.is_array()) return {impl_->quantity(key, node, dimension, allowed)};
    if (node.as_array()->empty()) impl_->wrong(key, node, "at least one quantity");
    std::vector<double> values;
    for (const toml::node& element : *node.as_array())
        values.push_back(impl_->quantity(key, element, dimension, allowed));
    return values;
}

double SettingsTable::number(std::string_view key, Range allowed) {
    return impl_->number(key, impl_->need(key, "a number, " + to_text(allowed)), allowed);
}

double SettingsTable::number(std::string_view key, Range allowed, double otherwise) {
    const toml::node* node = impl_->find(key);
    return node != nullptr ? impl_->number(key, *node, allowed) : otherwise;
}

int SettingsTable::integer(std::string_view key, int min, int max, int otherwise) {
    const toml::node* node = impl_->find(key);
    if (node == nullptr) return otherwise;
    const auto value = node->value_exact<std::int64_t>();
    if (!value || *value < min || *value > max)
        impl_->wrong(key, *node, "a whole number, " + std::to_string(min) + " to " + std::to_string(max));
    return static_cast<int>(*value);
}

bool SettingsTable::flag(std::string_view key, bool otherwise) {
    const toml::node* node = impl_->find(key);
    if (node == nullptr) return otherwise;
    if (!node->is_boolean()) impl_->wrong(key, *node, "true or false");
    return node->as_boolean()->get();
}

std::string SettingsTable::text(std::string_view key) {
    return impl_->text(key, impl_->need(key, "a string in quotes"));
}

std::string SettingsTable::text(std::string_view key, std::string otherwise) {
    const toml::node* node = impl_->find(key);
    return node != nullptr ? impl_->text(key, *node) : std::move(otherwise);
}

std::vector<double> SettingsTable::numbers(std::string_view key, std::size_t count) {
    constexpr Range finite{-INFINITY, INFINITY};
    std::vector<double> values;
    for (const toml::node& node : impl_->array(key, count, count, "numbers"))
        values.push_back(impl_->number(key, node, finite));
    return values;
}

std::vector<std::string> SettingsTable::texts(std::string_view key, std::size_t count) {
    return texts(key, count, count);
}

std::vector<std::string> SettingsTable::texts(std::string_view key, std::size_t least, std::size_t most) {
    std::vector<std::string> values;
    for (const toml::node& node : impl_->array(key, least, most, "texts"))
        values.push_back(impl_->text(key, node));
    return values;
}

std::size_t SettingsTable::choice(std::string_view key, std::span<const std::string_view> allowed,
                                  std::optional<std::size_t> otherwise) {
    const std::string expected = "one of " + quoted_list({allowed.begin(), allowed.end()});
    const toml::node* node = impl_->find(key);
    if (node == nullptr && otherwise) return *otherwise;
    if (node == nullptr) node = &impl_->need(key, expected);
    const auto value = node->value_exact<std::string_view>();
    const auto found = value ? std::ranges::find(allowed, *value) : allowed.end();
    if (found == allowed.end()) impl_->wrong(key, *node, expected);
    return static_cast<std::size_t>(found - allowed.begin());
}

SettingsTable SettingsTable::table(std::string_view key) {
    const toml::node* node = impl_->find(key);
    if (node != nullptr && !node->is_table()) impl_->wrong(key, *node, "a table [" + std::string{key} + "]");
    return SettingsTable{impl_->child(key, node != nullptr ? node->as_table() : nullptr)};
}

std::vector<SettingsTable> SettingsTable::tables(std::string_view key) {
    const toml::node* node = impl_->find(key);
    return node != nullptr ? impl_->tables(key, *node) : std::vector<SettingsTable>{};
}

std::vector<std::vector<SettingsTable>> SettingsTable::lists_of_tables(std::string_view key) {
    const toml::node* node = impl_->find(key);
    std::vector<std::vector<SettingsTable>> result;
    if (node == nullptr) return result;
    if (!node->is_array()) impl_->wrong(key, *node, "an array of arrays of tables");
    for (const toml::node& element : *node->as_array()) result.push_back(impl_->tables(key, element));
    return result;
}

void SettingsTable::finish() const {
    if (impl_->here == nullptr) return;
    const toml::key* first = nullptr;
    for (const auto& [key, node] : *impl_->here) {
        const bool earlier = first == nullptr || key.source().begin.line < first->source().begin.line;
        if (!impl_->known.contains(key.str()) && earlier) first = &key;
    }
    if (first == nullptr) return;
    const std::string guess = nearest(first->str(), impl_->known);
    impl_->fail(first->str(), "unknown key" + (guess.empty() ? "" : "; did you mean \"" + guess + "\"?") +
                                  " (known: " + quoted_list({impl_->known.begin(), impl_->known.end()}) +
                                  ")");
}

void SettingsTable::fail(std::string_view key, const std::string& why) const { impl_->fail(key, why); }

std::filesystem::path SettingsTable::folder() const {
    return std::filesystem::path{impl_->file}.parent_path();
}

}  // namespace shaker
