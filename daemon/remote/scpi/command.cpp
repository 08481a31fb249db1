#include "daemon/remote/scpi/command.hpp"

#include "daemon/remote/scpi/error.hpp"

namespace shaker::scpi {

namespace {

bool at_end(const Text& text) noexcept { return text.empty() || text.peek() == ';'; }

/// True if another value follows.
bool skip_separator(Text& text) {
    text.skip_blanks();
    if (at_end(text)) return false;
    if (text.peek() != ',')
        throw Error{Code::invalid_separator,
                    printable({text.at, 1}) + " where a comma or semicolon was expected"};
    ++text.at;
    text.skip_blanks();
    return true;
}

/// "1,5": a number, a comma and a digit without a blank.
bool before_decimal_comma(const Element& element, const Text& text) noexcept {
    return element.form == Element::Form::number && element.suffix.empty() && text.size() > 1 &&
           text.peek() == ',' && is_digit(text.at[1]);
}

std::string values(std::size_t count) { return std::to_string(count) + (count == 1 ? " value" : " values"); }

}  // namespace

std::span<const Argument> read_arguments(Text& text, std::span<const Parameter> parameters, Arguments& into) {
    std::size_t count = 0;
    text.skip_blanks();
    for (bool more = !at_end(text); more; more = skip_separator(text)) {
        const Element element = read_element(text);
        if (count == parameters.size())
            throw Error{Code::parameter_not_allowed, "takes at most " + values(count)};
        if (count + 1 == parameters.size() && before_decimal_comma(element, text))
            throw Error{Code::parameter_not_allowed,
                        "takes at most " + values(parameters.size()) +
                            ": a comma separates values; the decimal sign is a point"};
        into[count] = to_argument(element, parameters[count]);
        ++count;
    }
    for (std::size_t i = count; i < parameters.size(); ++i) {
        if (!parameters[i].optional) {
            std::size_t least = 0;
            while (least < parameters.size() && !parameters[least].optional) ++least;
            throw Error{Code::missing_parameter,
                        "needs " + values(least) + ", " + std::to_string(count) + " came"};
        }
        into[i] = Argument{.number = parameters[i].standard};
    }
    return std::span{into}.first(parameters.size());
}

bool read_bound(Text& text, Bound& bound) {
    text.skip_blanks();
    if (at_end(text)) return false;
    const Element element = read_element(text);
    if (element.form != Element::Form::word || !is_bound(element.word, bound))
        throw Error{Code::parameter_not_allowed, printable(element.raw) + ", allowed MIN, MAX or DEF"};
    if (skip_separator(text)) throw Error{Code::parameter_not_allowed, "takes at most 1 value"};
    return true;
}

}  // namespace shaker::scpi
