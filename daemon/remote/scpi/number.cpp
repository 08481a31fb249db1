#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/parameter.hpp"

namespace shaker::scpi {
namespace {

constexpr std::ptrdiff_t most_digits = 255;  // of a mantissa, IEEE 488.2 7.7.2.4.1
constexpr int largest_exponent = 32000;

struct Exponent {
    bool given = false;
    int value = 0;
};

/// Leaves `text` unchanged unless an E with digits follows: "1 EV" is a number with a unit.
Exponent read_exponent(Text& text) {
    Text look = text;
    look.skip_blanks();
    if (upper(look.peek()) != 'E') return {};
    ++look.at;
    look.skip_blanks();
    const bool negative = look.peek() == '-';
    if (negative || look.peek() == '+') ++look.at;
    if (!is_digit(look.peek())) return {};
    int value = 0;
    for (; is_digit(look.peek()); ++look.at) value = std::min(10 * value + (*look.at - '0'), 1000000);
    text = look;
    return {true, negative ? -value : value};
}

/// mantissa: digits with at most one point.
double scaled(std::string_view mantissa, int exponent) {
    std::array<char, most_digits + 16> buffer{};
    auto* end = std::copy(mantissa.begin(), mantissa.end(), buffer.begin());
    *end++ = 'e';
    end = std::to_chars(end, buffer.end(), exponent).ptr;
    double value = 0;
    const auto result = std::from_chars(buffer.begin(), end, value);
    if (result.ec != std::errc::result_out_of_range) return value;
    return exponent < 0 ? 0 : std::numeric_limits<double>::infinity();
}

constexpr bool may_be_unit(char c) noexcept {
    return is_letter(c) || is_digit(c) || c == '/' || c == '.' || c == '-' || c == '^' || c == '(' ||
           c == ')';
}

std::string_view read_suffix(Text& text) {
    Text look = text;
    look.skip_blanks();
    if (!is_letter(look.peek()) && look.peek() != '/') return {};
    const char* const from = look.at;
    while (may_be_unit(look.peek())) ++look.at;
    text = look;
    return {from, static_cast<std::size_t>(look.at - from)};
}

}  // namespace

void read_decimal(Text& text, Element& element) {
    element.form = Element::Form::number;
    const char* const from = text.at;
    const auto raw = [&] { return std::string_view{from, static_cast<std::size_t>(text.at - from)}; };
    const bool negative = *text.at == '-';
    if (negative || *text.at == '+') ++text.at;
    const char* const mantissa = text.at;
    std::ptrdiff_t digits = 0;
    bool point = false;
    for (; is_digit(text.peek()) || (text.peek() == '.' && !point); ++text.at) {
        point = point || *text.at == '.';
        digits += *text.at != '.';
    }
    if (digits == 0) throw Error{Code::invalid_character_in_number, printable(raw()) + " has no digits"};
    if (digits > most_digits) throw Error{Code::too_many_digits, printable(raw()) + " has more than 255"};
    const std::string_view figures{mantissa, static_cast<std::size_t>(text.at - mantissa)};
    const Exponent exponent = read_exponent(text);
    if (std::abs(exponent.value) > largest_exponent)
        throw Error{Code::exponent_too_large, printable(raw()) + ", allowed -32000 to 32000"};
    if (exponent.given)
        element.number = scaled(figures, exponent.value);
    else
        std::from_chars(figures.begin(), figures.end(), element.number);
    if (negative) element.number = -element.number;
    element.suffix = read_suffix(text);
    element.raw = raw();
    const char next = text.peek();
    if (!is_blank(next) && next != ',' && next != ';') {
        ++text.at;
        const Code code = element.suffix.empty() ? Code::invalid_character_in_number : Code::invalid_suffix;
        throw Error{code, printable(raw())};
    }
}

void read_nondecimal(Text& text, Element& element) {
    element.form = Element::Form::number;
    const char* const from = text.at - 1;  // the #
    const char letter = upper(text.peek());
    const int base = letter == 'H' ? 16 : letter == 'Q' ? 8 : 2;
    ++text.at;
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.at, text.end, value, base);
    const bool none = end == text.at;
    text.at += end - text.at;
    element.raw = {from, static_cast<std::size_t>(text.at - from)};
    if (error == std::errc::result_out_of_range)
        throw Error{Code::too_many_digits, printable(element.raw) + " has more than 64 bits"};
    const char next = text.peek();
    if (none || (!is_blank(next) && next != ',' && next != ';'))
        throw Error{Code::invalid_character_in_number, printable(element.raw)};
    element.number = static_cast<double>(value);
}

}  // namespace shaker::scpi
