#pragma once
// Values of the JSON body of an order. All functions throw InputError that names the key.
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "drivers/quantity.hpp"

namespace shaker::web {

/// The keys that the body of an order may have.
using Keys = std::span<const std::string_view>;

/// Refuses an object with another key: "gama: unknown key; expected gamma, phi".
void require_known(const nlohmann::json& object, Keys known);
/// The object of a body, with known keys only; without keys for an empty body.
nlohmann::json fields_of(const std::string& body, Keys known);
/// Refuses a body that has keys.
void require_no_fields(const std::string& body);

/// A quantity: a number in SI, or a text as parse_quantity() reads it ("0.7 g"), which also checks the range.
/// `otherwise` for a missing key or null.
double quantity_at(const nlohmann::json& fields, std::string_view key, Dimension dimension, Range allowed,
                   double otherwise);
/// A whole number, or its digits as a text; `otherwise` for a missing key or null.
int whole_at(const nlohmann::json& fields, std::string_view key, int otherwise, Range allowed);
/// A string; none for a missing key.
std::optional<std::string> text_at(const nlohmann::json& fields, std::string_view key);
/// True or false; none for a missing key.
std::optional<bool> flag_at(const nlohmann::json& fields, std::string_view key);

}  // namespace shaker::web
