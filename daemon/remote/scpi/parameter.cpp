#include "daemon/remote/scpi/parameter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "daemon/remote/scpi/error.hpp"
#include "drivers/quantity.hpp"

namespace shaker::scpi {

namespace {

/// Replaces doubled quotes by single ones in place.
void read_string(Text& text, Element& element) {
    element.form = Element::Form::string;
    const char* const from = text.at;
    const char quote = *text.at++;
    char* const content = text.at;
    char* out = content;
    for (;; ++text.at) {
        if (text.empty()) {
            const auto size = static_cast<std::size_t>(text.at - from);
            throw Error{Code::invalid_string, printable({from, size}) + " has no closing quote"};
        }
        if (*text.at == quote) {
            if (text.size() < 2 || text.at[1] != quote) break;
            ++text.at;
        }
        *out++ = *text.at;
    }
    ++text.at;
    element.raw = {from, static_cast<std::size_t>(text.at - from)};
    element.content = {content, static_cast<std::size_t>(out - content)};
}

/// #<n><n digits><data>, or #0<data> up to the end of the message.
void read_block(Text& text, Element& element) {
    element.form = Element::Form::block;
    const char* const from = text.at - 1;  // the #
    std::size_t digits = static_cast<std::size_t>(*text.at++ - '0');
    std::uint64_t length = text.size();
    if (digits > 0) {
        for (length = 0; digits > 0 && is_digit(text.peek()); --digits)
            length = 10 * length + static_cast<std::uint64_t>(*text.at++ - '0');
        if (digits > 0 || length > text.size())
            throw Error{Code::invalid_block,
                        printable({from, static_cast<std::size_t>(text.at - from)}) + " has no length"};
    }
    element.raw = {from, static_cast<std::size_t>(text.at - from)};  // the head only: the data are not text
    element.content = {text.at, length};
    text.at += length;
}

void read_word(Text& text, Element& element) {
    element.form = Element::Form::word;
    const char* const from = text.at;
    for (std::size_t i = 0; is_word(text.peek()); ++i, ++text.at)
        if (i < longest_mnemonic) element.word.put(i, *text.at);
    element.raw = {from, static_cast<std::size_t>(text.at - from)};
    if (element.raw.size() > longest_mnemonic)
        throw Error{Code::invalid_character_data, printable(element.raw) + " has more than 12 characters"};
}

std::vector<Keyword> keywords(std::string_view written) {
    std::vector<Keyword> words;
    while (!written.empty()) {
        const auto bar = std::min(written.find('|'), written.size());
        words.emplace_back(written.substr(0, bar));
        written.remove_prefix(std::min(bar + 1, written.size()));
    }
    return words;
}

std::string allowed(const Parameter& parameter) {
    std::string text;
    if (parameter.numeric())
        text = to_text(Range{parameter.min, parameter.max}) + parameter.unit.label();
    else if (parameter.kind == Kind::boolean)
        text = "ON, OFF or a number";
    else if (parameter.kind == Kind::string)
        text = "a string in quotes";
    else if (parameter.kind == Kind::block)
        text = "a block";
    for (const Keyword& word : parameter.words) text += (text.empty() ? "" : " or ") + word.short_form;
    return text;
}

Error refused(Code code, const Element& element, const Parameter& parameter) {
    return Error{code, printable(element.raw) + ", allowed " + allowed(parameter)};
}

int place_of(const Mnemonic& word, const std::vector<Keyword>& words) {
    for (std::size_t i = 0; i < words.size(); ++i)
        if (words[i].is(word)) return static_cast<int>(i);
    return -1;
}

bool takes(const Parameter& parameter, Element::Form form) {
    switch (form) {
        case Element::Form::number:
            return parameter.numeric() || parameter.kind == Kind::boolean;
        case Element::Form::word:
            return parameter.numeric() || parameter.kind == Kind::boolean || parameter.kind == Kind::choice;
        case Element::Form::string:
            return parameter.kind == Kind::string;
        case Element::Form::block:
            return parameter.kind == Kind::block;
    }
    return false;
}

Code not_allowed(Element::Form form) {
    constexpr std::array codes{Code::numeric_not_allowed, Code::character_data_not_allowed,
                               Code::string_not_allowed, Code::block_not_allowed};
    return codes.at(static_cast<std::size_t>(form));
}

void take_word(const Element& element, const Parameter& parameter, Argument& argument) {
    static const Mnemonic on = mnemonic("ON"), off = mnemonic("OFF");
    Bound bound{};
    if (parameter.kind == Kind::boolean) {
        argument.on = element.word == on;
        if (!argument.on && element.word != off) throw refused(Code::data_type, element, parameter);
        return;
    }
    argument.word = place_of(element.word, parameter.words);
    if (argument.word >= 0) return;
    if (parameter.kind == Kind::choice) throw refused(Code::illegal_value, element, parameter);
    if (!is_bound(element.word, bound)) throw refused(Code::invalid_character_data, element, parameter);
    argument.number = value_of(parameter, bound);
}

void take_number(const Element& element, const Parameter& parameter, Argument& argument) {
    argument.number = parameter.unit.convert(element.number, element.suffix);
    if (parameter.kind != Kind::number) argument.number = std::round(argument.number);
    argument.on = argument.number != 0;
    if (parameter.numeric() && !(argument.number >= parameter.min && argument.number <= parameter.max))
        throw refused(Code::out_of_range, element, parameter);
}

}  // namespace

Element read_element(Text& text) {
    Element element;
    const char first = text.peek();
    if (is_digit(first) || first == '+' || first == '-' || first == '.') {
        read_decimal(text, element);
    } else if (is_letter(first)) {
        read_word(text, element);
    } else if (first == '"' || first == '\'') {
        read_string(text, element);
    } else if (first == '#') {
        ++text.at;
        if (is_digit(text.peek()))
            read_block(text, element);
        else if (upper(text.peek()) == 'H' || upper(text.peek()) == 'Q' || upper(text.peek()) == 'B')
            read_nondecimal(text, element);
        else
            throw Error{Code::invalid_block, "# without a length, H, Q or B"};
    } else if (first == '(') {
        throw Error{Code::expression, "expressions and channel lists are not supported"};
    } else if (first == ',' || first == ';' || is_blank(first)) {
        throw Error{Code::syntax, "a value is missing between separators"};
    } else {
        throw Error{Code::invalid_character, printable({text.at, 1})};
    }
    return element;
}

Parameter number(std::string_view unit, double min, double max, double standard) {
    return {.kind = Kind::number, .unit = Unit{unit}, .min = min, .max = max, .standard = standard};
}
Parameter integer(double min, double max, double standard) {
    return {.kind = Kind::integer, .min = min, .max = max, .standard = standard};
}
Parameter boolean() { return {.kind = Kind::boolean}; }
Parameter choice(std::string_view words) { return {.kind = Kind::choice, .words = keywords(words)}; }
Parameter string(std::size_t longest) { return {.kind = Kind::string, .longest = longest}; }
Parameter block(std::size_t longest) { return {.kind = Kind::block, .longest = longest}; }
Parameter optional(Parameter parameter) {
    parameter.optional = true;
    return parameter;
}
Parameter or_word(std::string_view words, Parameter parameter) {
    parameter.words = keywords(words);
    return parameter;
}

Argument to_argument(const Element& element, const Parameter& parameter) {
    if (!takes(parameter, element.form)) throw refused(not_allowed(element.form), element, parameter);
    Argument argument{.given = true, .text = element.content};
    if (element.form == Element::Form::word)
        take_word(element, parameter, argument);
    else if (element.form == Element::Form::number)
        take_number(element, parameter, argument);
    else if (element.content.size() > parameter.longest)
        throw Error{Code::too_much_data, std::to_string(element.content.size()) + " bytes, allowed at most " +
                                             std::to_string(parameter.longest)};
    return argument;
}

bool is_bound(const Mnemonic& word, Bound& bound) noexcept {
    static const std::array<Keyword, 3> bounds{Keyword{"MINimum"}, Keyword{"MAXimum"}, Keyword{"DEFault"}};
    for (std::size_t i = 0; i < bounds.size(); ++i) {
        if (!bounds[i].is(word)) continue;
        bound = static_cast<Bound>(i);
        return true;
    }
    return false;
}

double value_of(const Parameter& parameter, Bound bound) {
    const double value = bound == Bound::minimum   ? parameter.min
                         : bound == Bound::maximum ? parameter.max
                                                   : parameter.standard;
    if (std::isfinite(value)) return value;
    constexpr std::array names{"MINimum", "MAXimum", "DEFault"};
    throw Error{Code::illegal_value, std::string{names.at(static_cast<std::size_t>(bound))} +
                                         " is not defined for this parameter"};
}

}  // namespace shaker::scpi
