#pragma once
// The values of one order, checked by its row.
#include <map>
#include <string>
#include <string_view>
#include <variant>

#include "daemon/orders/row.hpp"

namespace shaker::orders {

/// All functions that add a value throw InputError with the key, the value and what is allowed.
class Values {
public:
    explicit Values(const Row& row) : row_{&row} {}

    /// The field with this key. InputError, which lists the known keys, when the row has no such field.
    [[nodiscard]] const Field& field(std::string_view key) const;
    void add_number(std::string_view key, double number);
    void add_text(std::string_view key, const std::string& text);
    void add_flag(std::string_view key, bool on);
    /// The key was given without a value (null in JSON).
    void add_nothing(std::string_view key);
    /// Throws the refusal of a value that has another kind. shown: the value as text.
    [[noreturn]] void refuse(std::string_view key, const std::string& shown) const;
    /// Throws InputError when a needed field has no value.
    void require_complete() const;

    [[nodiscard]] const Row& row() const noexcept { return *row_; }
    /// A value was given.
    [[nodiscard]] bool has(std::string_view key) const;
    /// The key was given without a value.
    [[nodiscard]] bool is_nothing(std::string_view key) const;
    /// In SI units.
    [[nodiscard]] double number(std::string_view key, double otherwise) const;
    [[nodiscard]] int whole(std::string_view key, int otherwise) const;
    [[nodiscard]] bool flag(std::string_view key, bool otherwise) const;
    [[nodiscard]] std::string text(std::string_view key, std::string_view otherwise = {}) const;
    /// A value of kind `free`, in SI units.
    [[nodiscard]] double quantity(std::string_view key, Dimension dimension, Range allowed) const;

private:
    const Row* row_;
    std::map<std::string_view, std::variant<std::monostate, double, bool, std::string>> given_;
};

}  // namespace shaker::orders
