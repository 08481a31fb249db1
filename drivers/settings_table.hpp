#pragma once
// One table of a TOML settings file, read strictly: an unknown key is an error, and so is a value of the
// wrong type or out of range. InputError names file, line, key, value and what is allowed.
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/quantity.hpp"

namespace shaker {

class SettingsTable {
public:
    /// Parses a file. TOML syntax errors are reported with line and column.
    static SettingsTable from_file(const std::filesystem::path& file);
    static SettingsTable from_text(std::string_view text, std::string file_name);
    SettingsTable(SettingsTable&&) noexcept;
    SettingsTable& operator=(SettingsTable&&) noexcept;
    ~SettingsTable();

    [[nodiscard]] bool has(std::string_view key) const;
    /// Required values: throws when the key is missing.
    double number(std::string_view key, Range allowed);
    std::string text(std::string_view key);
    /// Optional values: `otherwise` when the key is missing.
    double number(std::string_view key, Range allowed, double otherwise);
    int integer(std::string_view key, int min, int max, int otherwise);
    bool flag(std::string_view key, bool otherwise);
    std::string text(std::string_view key, std::string otherwise);
    /// Required arrays of exactly `count` values.
    std::vector<double> numbers(std::string_view key, std::size_t count);
    std::vector<std::string> texts(std::string_view key, std::size_t count);
    /// Required array of `least` to `most` texts.
    std::vector<std::string> texts(std::string_view key, std::size_t least, std::size_t most);
    /// The index in `allowed` of the value.
    std::size_t choice(std::string_view key, std::span<const std::string_view> allowed,
                       std::optional<std::size_t> otherwise = {});
    std::size_t choice(std::string_view key, std::initializer_list<std::string_view> allowed,
                       std::optional<std::size_t> otherwise = {}) {
        return choice(key, std::span{allowed.begin(), allowed.size()}, otherwise);
    }
    /// A quantity as parse_quantity() reads it: a string with a unit ("1.5g"), or a number in SI units.
    double quantity(std::string_view key, Dimension dimension, Range allowed);
    double quantity(std::string_view key, Dimension dimension, Range allowed, double otherwise);
    /// One quantity, or an array of at least one.
    std::vector<double> quantities(std::string_view key, Dimension dimension, Range allowed);
    /// True if the value at `key` is a string, a table.
    [[nodiscard]] bool is_text(std::string_view key) const;
    [[nodiscard]] bool is_table(std::string_view key) const;
    /// The line of the file with `key`, or where the table begins.
    [[nodiscard]] std::size_t line(std::string_view key) const;
    /// A sub-table; an empty one, equally strict, when missing.
    SettingsTable table(std::string_view key);
    /// An array of tables; empty when missing.
    std::vector<SettingsTable> tables(std::string_view key);
    /// An array of arrays of tables; empty when missing.
    std::vector<std::vector<SettingsTable>> lists_of_tables(std::string_view key);
    /// Throws if the file has a key that was never read; names the key and its line, and lists the
    /// known keys.
    void finish() const;
    /// Throws InputError with file and line of `key` (or of the table), for checks of the caller.
    [[noreturn]] void fail(std::string_view key, const std::string& why) const;
    /// Folder of the file. Relative paths in the file start here.
    [[nodiscard]] std::filesystem::path folder() const;

private:
    struct Impl;
    explicit SettingsTable(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace shaker
