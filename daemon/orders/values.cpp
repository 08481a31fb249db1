#include "daemon/orders/values.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "drivers/errors.hpp"

namespace shaker::orders {

namespace {

constexpr std::size_t longest_shown = 64;  // bytes of an unknown key in its refusal

std::string expected(const Field& field) {
    switch (field.kind) {
        case Kind::quantity:
            return fmt::format("a number in SI units, or a text such as \"{}\"",
                               field.dimension == Dimension::ratio ? "50 %" : "0.7 g");
        case Kind::whole:
            return fmt::format("a whole number from {} to {}", field.allowed.min, field.allowed.max);
        case Kind::word:
            return fmt::format("one of {}", fmt::join(field.words, ", "));
        case Kind::flag:
            return "true or false";
        case Kind::free:
            return "a number in SI units, or a text with a unit";
        case Kind::regions:
            return "a list of objects with camera, target and region_px";
        case Kind::text:
            break;
    }
    return "a string";
}

int whole_of(const Field& field, double number, const std::string& shown) {
    if (number >= field.allowed.min && number <= field.allowed.max && number == std::floor(number))
        return static_cast<int>(number);
    throw InputError{fmt::format("{} {}: expected {}", field.key, shown, expected(field))};
}

}  // namespace

const Field& Values::field(std::string_view key) const {
    const auto found = std::ranges::find(row_->fields, key, &Field::key);
    if (found != row_->fields.end()) return *found;
    std::string known;
    for (const Field& f : row_->fields) known.append(known.empty() ? "" : ", ").append(f.key);
    throw InputError{fmt::format("{}: unknown key; expected {}", key.substr(0, longest_shown),
                                 known.empty() ? "none" : known)};
}

void Values::refuse(std::string_view key, const std::string& shown) const {
    throw InputError{fmt::format("{} {}: expected {}", key, shown, expected(field(key)))};
}

void Values::add_number(std::string_view key, double number) {
    const Field& f = field(key);
    if (f.kind == Kind::whole)
        given_[f.key] = static_cast<double>(whole_of(f, number, to_text(number)));
    else if (f.kind == Kind::quantity)
        given_[f.key] = parse_quantity(f.key, to_text(number), f.dimension, f.allowed);
    else if (f.kind == Kind::free)
        given_[f.key] = to_text(number);
    else
        refuse(key, to_text(number));
}

void Values::add_text(std::string_view key, const std::string& text) {
    const Field& f = field(key);
    const std::string shown = '"' + text + '"';
    if (f.kind == Kind::quantity) {
        given_[f.key] = parse_quantity(f.key, text, f.dimension, f.allowed);
    } else if (f.kind == Kind::whole) {
        double number = NAN;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        const bool whole = error == std::errc{} && end == text.data() + text.size();
        given_[f.key] = static_cast<double>(whole_of(f, whole ? number : NAN, shown));
    } else if (f.kind == Kind::flag || f.kind == Kind::regions ||
               (f.kind == Kind::word && std::ranges::find(f.words, text) == f.words.end())) {
        refuse(key, shown);
    } else {
        given_[f.key] = text;
    }
}

void Values::add_flag(std::string_view key, bool on) {
    const Field& f = field(key);
    if (f.kind != Kind::flag) refuse(key, on ? "true" : "false");
    given_[f.key] = on;
}

void Values::add_nothing(std::string_view key) { given_[field(key).key] = {}; }

void Values::require_complete() const {
    for (const Field& f : row_->fields)
        if (f.needed && !has(f.key))
            throw InputError{fmt::format("{}: missing; expected {}", f.key, expected(f))};
}

bool Values::has(std::string_view key) const {
    const auto found = given_.find(key);
    return found != given_.end() && found->second.index() != 0;
}

bool Values::is_nothing(std::string_view key) const { return given_.contains(key) && !has(key); }

double Values::number(std::string_view key, double otherwise) const {
    return has(key) ? std::get<double>(given_.at(key)) : otherwise;
}

int Values::whole(std::string_view key, int otherwise) const {
    return static_cast<int>(number(key, otherwise));
}

bool Values::flag(std::string_view key, bool otherwise) const {
    return has(key) ? std::get<bool>(given_.at(key)) : otherwise;
}

std::string Values::text(std::string_view key, std::string_view otherwise) const {
    return has(key) ? std::get<std::string>(given_.at(key)) : std::string{otherwise};
}

double Values::quantity(std::string_view key, Dimension dimension, Range allowed) const {
    if (!has(key)) throw InputError{fmt::format("{}: missing; expected {}", key, expected(field(key)))};
    return parse_quantity(key, text(key), dimension, allowed);
}

}  // namespace shaker::orders
