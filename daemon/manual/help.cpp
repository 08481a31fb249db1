#include "daemon/manual/help.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "daemon/manual/manual_page.hpp"

namespace shaker::manual {

namespace {

constexpr std::size_t most_columns = 100;
constexpr std::size_t term_columns = 28;
constexpr std::size_t most_words_in_name = 4;

std::string_view unit_of(Dimension dimension) {
    switch (dimension) {
        case Dimension::acceleration:
            return " m/s^2";
        case Dimension::angle:
            return " rad";
        case Dimension::frequency:
            return " Hz";
        case Dimension::time:
            return " s";
        case Dimension::velocity:
            return " m/s";
        case Dimension::length:
            return " m";
        case Dimension::ratio:
            break;
    }
    return "";
}

// Empty when help or value name already contain the allowed values.
std::string allowed(const Argument& a) {
    if (a.kind == Kind::whole) return fmt::format(" ({:.0f} to {:.0f})", a.allowed.min, a.allowed.max);
    if (a.kind == Kind::quantity)
        return fmt::format(" ({:.7g} to {:.7g}{})", a.allowed.min, a.allowed.max, unit_of(a.dimension));
    if (a.kind == Kind::word && a.words.size() > most_words_in_name)
        return fmt::format(": {}", fmt::join(a.words, ", "));
    return {};
}

std::string row(const std::string& term, const std::string& text) {
    const std::string indent(term_columns + 4, ' ');
    std::string lines = filled(text, most_columns - indent.size());
    for (auto at = lines.find('\n'); at != std::string::npos; at = lines.find('\n', at + indent.size()))
        lines.insert(at + 1, indent);
    const bool fits = term.size() <= term_columns;
    return fmt::format("  {:<{}}{}{}\n", term, term_columns + 2, fits ? "" : fmt::format("\n{}", indent),
                       lines);
}

std::string option_term(const Argument& a) {
    const std::string value = value_name(a);
    return fmt::format("{}{}{}{}", a.letter == 0 ? "" : fmt::format("-{}, ", a.letter), a.name,
                       value.empty() ? "" : " ", a.bare ? fmt::format("[{}]", value) : value);
}

std::string rows(const char* heading, std::span<const Argument> arguments, bool positional) {
    std::string text;
    for (const Argument& a : arguments)
        if (a.positional() == positional) text += row(option_term(a), meaning(a));
    return text.empty() ? text : fmt::format("\n{}:\n{}", heading, text);
}

std::string exit_rows(const Program& program, const Command* command) {
    std::string text = "\nExit status:\n";
    for (const ExitStatus& s : program.exit_statuses)
        if (command == nullptr || may_end_with(*command, s))
            text += fmt::format("  {:>2}  {}\n", s.number, s.meaning);
    return text;
}

std::string help_of(const Program& program, const Command& command) {
    const bool options = std::ranges::any_of(command.arguments, [](auto& a) { return !a.positional(); });
    const std::string places = positional_names(command);
    std::string text =
        fmt::format("Usage: {} {}{}{}{}\n\n{}\n", program.name, command.name, options ? " [OPTIONS]" : "",
                    places.empty() ? "" : " ", places, filled(sentences(command), most_columns));
    text += rows("Arguments", command.arguments, true);
    text += rows("Options", command.arguments, false);
    text += rows("Options of every command", program.common, false);
    const bool quantities =
        std::ranges::any_of(command.arguments, [](auto& a) { return a.kind == Kind::quantity; });
    if (quantities) text += fmt::format("\n{}\n", filled(program.notation, most_columns));
    text += exit_rows(program, &command);
    if (!command.example.empty()) text += fmt::format("\nExample:\n  {}\n", command.example);
    return text;
}

}  // namespace

std::string value_name(const Argument& a) {
    if (a.positional() || a.kind == Kind::flag) return {};
    if (a.value.empty()) return fmt::format("{}", fmt::join(a.words, "|"));
    return std::string{a.value};
}

std::string meaning(const Argument& a) {
    const std::string_view not_given = a.standard.empty() ? a.otherwise : a.standard;
    return fmt::format("{}{}{}", a.help, allowed(a),
                       not_given.empty() ? "" : fmt::format(" [{}]", not_given));
}

std::string sentences(const Command& command) {
    return fmt::format("{}.{}{}", command.summary, command.details.empty() ? "" : " ", command.details);
}

std::string positional_names(const Command& command) {
    std::string names;
    for (const Argument& a : command.arguments)
        if (a.positional()) names += fmt::format("{}{}", names.empty() ? "" : " ", a.name);
    return names;
}

std::string help(const Program& program, const Command* command) {
    if (command != nullptr) return help_of(program, *command);
    std::string text = fmt::format("Usage: {} {}\n\n{}\n\nCommands:\n", program.name, program.synopsis,
                                   filled(program.about, most_columns));
    for (const Command& c : program.commands) text += row(std::string{c.name}, std::string{c.summary});
    text += rows("Options of every command", program.common, false);
    return text + fmt::format("\n{}\n{}\n\"{} COMMAND --help\" describes a command.\n",
                              filled(program.notation, most_columns), exit_rows(program, nullptr),
                              program.name);
}

}  // namespace shaker::manual
