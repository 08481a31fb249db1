#include "daemon/remote/scpi/data/element.hpp"

#include <algorithm>
#include <cstdint>

#include "daemon/remote/scpi/data/error.hpp"

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

}  // namespace shaker::scpi
