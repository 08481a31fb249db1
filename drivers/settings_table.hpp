#pragma once
// One table of a TOML settings file, read strictly: every key that is there must be asked for, every value
// must be of its kind and in its range. Errors (InputError) name file, line, key, value and what is allowed.
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/quantity.hpp"

namespace shaker {

class SettingsTable {
public:
    /// Parses a file; errors in the TOML itself are reported with line and column.
    static SettingsTable from_file(const std::filesystem::path& file);
    static SettingsTable from_text(std::string_view text, std::string file_name);
    SettingsTable(SettingsTable&&) noexcept;
    SettingsTable& operator=(SettingsTable&&) noexcept;
    ~SettingsTable();

    [[nodiscard]] bool has(std::string_view key) const;
    /// Required values: an error when the key is missing.
    double number(std::string_view key, Range allowed);
    std::string text(std::string_view key);
    /// With a default when the key is missing.
    double number(std::string_view key, Range allowed, double otherwise);
    int integer(std::string_view key, int min, int max, int otherwise);
    bool flag(std::string_view key, bool otherwise);
    std::string text(std::string_view key, std::string otherwise);
    /// Required arrays of exactly `count` values.
    std::vector<double> numbers(std::string_view key, std::size_t count);
    std::vector<std::string> texts(std::string_view key, std::size_t count);
    /// One of `allowed`; returns its index.
    std::size_t choice(std::string_view key, std::initializer_list<std::string_view> allowed,
                       std::optional<std::size_t> otherwise = {});
    /// The value at `key` is a text (not an array or a number).
    [[nodiscard]] bool is_text(std::string_view key) const;
    /// A sub-table; an empty one (with the same strictness) when missing.
    SettingsTable table(std::string_view key);
    /// An array of tables; empty when missing.
    std::vector<SettingsTable> tables(std::string_view key);
    /// Throws when a key was never asked for, naming it and its line, and listing the keys that exist here.
    void finish() const;
    /// Throws InputError with file and line of `key` (or of the table): for checks that only the caller can
    /// make.
    [[noreturn]] void fail(std::string_view key, const std::string& why) const;
    /// Where the file is: relative paths in it are relative to this folder.
    [[nodiscard]] std::filesystem::path folder() const;

private:
    struct Impl;
    explicit SettingsTable(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace shaker
