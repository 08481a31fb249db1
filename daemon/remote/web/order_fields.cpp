#include "daemon/remote/web/order_fields.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "drivers/errors.hpp"

namespace shaker::web {

using nlohmann::json;

namespace {

constexpr std::size_t longest_shown = 64;  // bytes of an unknown key in its refusal

}  // namespace

void require_known(const json& object, Keys known) {
    for (const auto& item : object.items())
        if (std::ranges::find(known, item.key()) == known.end())
            throw InputError{fmt::format("{}: unknown key; expected {}", item.key().substr(0, longest_shown),
                                         known.empty() ? "none" : fmt::to_string(fmt::join(known, ", ")))};
}

json fields_of(const std::string& body, Keys known) {
    try {
        json fields = body.empty() ? json::object() : json::parse(body);
        if (!fields.is_object()) throw InputError{"expected a JSON object of settings"};
        require_known(fields, known);
        return fields;
    } catch (const json::exception& e) {
        throw InputError{std::string{"not JSON: "} + e.what()};
    }
}

void require_no_fields(const std::string& body) { static_cast<void>(fields_of(body, {})); }

double quantity_at(const json& fields, std::string_view key, Dimension dimension, Range allowed,
                   double otherwise) {
    if (!fields.contains(key) || fields[key].is_null()) return otherwise;
    const json& value = fields[key];
    if (!value.is_number() && !value.is_string())
        throw InputError{fmt::format("{}: expected a number in SI units, or a text such as \"0.7 g\"; got {}",
                                     key, value.dump())};
    return parse_quantity(key, value.is_string() ? value.get<std::string>() : to_text(value.get<double>()),
                          dimension, allowed);
}

int whole_at(const json& fields, std::string_view key, int otherwise, Range allowed) {
    if (!fields.contains(key) || fields[key].is_null()) return otherwise;
    const json& value = fields[key];
    double number = NAN;
    if (value.is_number()) number = value.get<double>();
    if (value.is_string()) {
        const auto& text = value.get_ref<const std::string&>();
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error != std::errc{} || end != text.data() + text.size()) number = NAN;
    }
    if (!(number >= allowed.min && number <= allowed.max) || number != std::floor(number))
        throw InputError{fmt::format("{}: {} is out of range; expected an integer from {} to {}", key,
                                     value.dump(), allowed.min, allowed.max)};
    return static_cast<int>(number);
}

std::optional<std::string> text_at(const json& fields, std::string_view key) {
    if (!fields.contains(key)) return std::nullopt;
    if (!fields[key].is_string())
        throw InputError{fmt::format("{}: expected a string, got {}", key, fields[key].dump())};
    return fields[key].get<std::string>();
}

std::optional<bool> flag_at(const json& fields, std::string_view key) {
    if (!fields.contains(key)) return std::nullopt;
    if (!fields[key].is_boolean())
        throw InputError{fmt::format("{}: expected true or false, got {}", key, fields[key].dump())};
    return fields[key].get<bool>();
}

}  // namespace shaker::web
