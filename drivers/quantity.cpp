#include "drivers/quantity.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>

#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker {
namespace {

// A factor in two parts: "50ms" is 50 / 1000, rounded once, where 50 * 0.001 would be rounded twice.
struct Unit {
    std::string_view name;
    double times;
    double over;
};

constexpr std::array acceleration_units{Unit{"m/s^2", 1, 1}, Unit{"mm/s^2", 1, 1e3}, Unit{"g", paper_g, 1},
                                        Unit{"m/s2", 1, 1},  Unit{"m/s²", 1, 1},     Unit{"G", paper_g, 1}};
constexpr std::array angle_units{Unit{"rad", 1, 1}, Unit{"mrad", 1, 1e3}, Unit{"deg", std::numbers::pi, 180},
                                 Unit{"°", std::numbers::pi, 180}};
constexpr std::array frequency_units{Unit{"Hz", 1, 1}, Unit{"kHz", 1e3, 1}, Unit{"mHz", 1, 1e3}};
constexpr std::array time_units{Unit{"s", 1, 1},    Unit{"ms", 1, 1e3}, Unit{"us", 1, 1e6},
                                Unit{"µs", 1, 1e6}, Unit{"ns", 1, 1e9}, Unit{"min", 60, 1},
                                Unit{"h", 3600, 1}};
constexpr std::array velocity_units{Unit{"m/s", 1, 1}, Unit{"mm/s", 1, 1e3}, Unit{"um/s", 1, 1e6}};
constexpr std::array length_units{Unit{"m", 1, 1}, Unit{"mm", 1, 1e3}, Unit{"um", 1, 1e6},
                                  Unit{"km", 1e3, 1}};
constexpr std::array ratio_units{Unit{"%", 1, 100}};

std::span<const Unit> units_of(Dimension dimension) {
    constexpr std::array<std::span<const Unit>, 7> units{acceleration_units, angle_units,    frequency_units,
                                                         time_units,         velocity_units, length_units,
                                                         ratio_units};
    return units.at(static_cast<std::size_t>(dimension));
}

/// To six digits: the change of the unit has made the others.
double rounded(double value) {
    std::array<char, 32> buffer{};
    const auto end =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 6);
    std::from_chars(buffer.data(), end.ptr, value);
    return value;
}

/// `in`: unit of the given value; null: SI.
std::string understood(Dimension dimension, Range allowed, const Unit* in) {
    const bool ratio = dimension == Dimension::ratio;
    const Unit si = ratio ? Unit{"", 1, 1} : units_of(dimension).front();
    const Unit& shown = in != nullptr ? *in : si;
    const std::string name = shown.name.empty() ? "" : " " + std::string{shown.name};
    for (double* end : {&allowed.min, &allowed.max}) *end = rounded(*end * shown.over / shown.times);
    std::string list = ratio ? "none" : "";
    for (const Unit& unit : units_of(dimension)) list += (list.empty() ? "" : ", ") + std::string{unit.name};
    return " (units understood: " + list + "; allowed: " + to_text(allowed) + name + ")";
}

/// The commas in the mantissa at the start of `text`; a sign in front is allowed.
struct Separators {
    std::size_t commas, first;  // first: place of the first comma
    bool decimal;               // one comma between digits, no point
};
Separators separators(std::string_view text) {
    const auto from = std::min(text.find_first_not_of('-'), text.size());
    const std::string_view mantissa = text.substr(0, text.find_first_not_of("0123456789.,", from));
    const auto digit = [&](std::size_t i) {
        return i < mantissa.size() && mantissa[i] >= '0' && mantissa[i] <= '9';
    };
    const auto commas = static_cast<std::size_t>(std::ranges::count(mantissa, ','));
    const auto first = mantissa.find(',');
    const bool decimal = commas == 1 && first > 0 && digit(first - 1) && digit(first + 1) &&
                         mantissa.find('.') == std::string_view::npos;
    return {commas, first, decimal};
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blank = " \t\r\n";
    const auto first = text.find_first_not_of(blank);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

}  // namespace

std::string to_text(double value) {
    std::array<char, 32> buffer{};
    const double size = std::abs(value);
    const bool plain = size >= 1e-4 && size < 1e6;  // 0.0006, not 6e-04
    const auto end =
        plain ? std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed)
              : std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    return {buffer.data(), end.ptr};
}

std::string to_text(Range range) {
    const bool from = std::isfinite(range.min), to = std::isfinite(range.max);
    if (from && to) return to_text(range.min) + " to " + to_text(range.max);
    if (from) return "at least " + to_text(range.min);
    return to ? "at most " + to_text(range.max) : "any number";
}

void require_allowed(std::string_view what, double value, Range allowed, std::string_view unit, double size) {
    if (value >= allowed.min && value <= allowed.max) return;
    throw InputError{fmt::format("{} {:.6g}{}: {:.6g} to {:.6g}{} is allowed", what, value / size, unit,
                                 allowed.min / size, allowed.max / size, unit)};
}

double parse_quantity(std::string_view what, std::string_view text, Dimension dimension, Range allowed) {
    const Unit* in = nullptr;
    const auto refuse = [&](const std::string& why) {
        return InputError{std::string{what} + " \"" + std::string{text} + "\": " + why +
                          understood(dimension, allowed, in)};
    };
    std::string with_point{trimmed(text)};
    if (with_point.starts_with('+') && !with_point.starts_with("+-")) with_point.erase(0, 1);
    if (const Separators found = separators(with_point); found.decimal)
        with_point[found.first] = '.';
    else if (found.commas > 0)
        throw refuse(
            "a comma is the decimal comma, once and between digits as in 1,5; digits have no other "
            "separator");
    const std::string_view rest = with_point;
    double value = 0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (error == std::errc::result_out_of_range) throw refuse("the number is too large or too small");
    if (error != std::errc{}) throw refuse("expected a number, then a unit");
    if (!std::isfinite(value)) throw refuse("expected a finite number");
    const std::string_view name = trimmed(rest.substr(static_cast<std::size_t>(end - rest.data())));
    if (!name.empty()) {
        for (const Unit& unit : units_of(dimension)) in = unit.name == name ? &unit : in;
        if (in == nullptr) throw refuse("unknown unit \"" + std::string{name} + "\"");
        value = value * in->times / in->over;
    }
    if (!(value >= allowed.min && value <= allowed.max)) throw refuse("out of range");
    return value;
}

}  // namespace shaker
