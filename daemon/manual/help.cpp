#include "daemon/manual/help.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <cctype>

namespace shaker::manual {

namespace {

constexpr std::size_t most_columns = 100;
constexpr std::size_t term_columns = 28;
constexpr std::size_t most_words_in_name = 4;

// The words of a text in lines of at most `width` characters, the last without its end.
std::string filled(std::string_view text, std::size_t width) {
    std::string out;
    std::size_t column = 0;
    while (true) {
        text.remove_prefix(std::min(text.find_first_not_of(" \n"), text.size()));
        if (text.empty()) return out;
        const std::string_view word = text.substr(0, text.find_first_of(" \n"));
        text.remove_prefix(word.size());
        const bool fits = column + 1 + word.size() <= width;
        if (!out.empty()) out += fits ? ' ' : '\n';
        column = (fits && !out.empty() ? column + 1 : 0) + word.size();
        out += word;
    }
}

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

// Name of the argument's value: "ACCELERATION", "off|region|full"; empty for flags and positional arguments.
std::string value_name(const Argument& a) {
    if (a.positional() || a.kind == Kind::flag) return {};
    if (a.value.empty()) return fmt::format("{}", fmt::join(a.words, "|"));
    return std::string{a.value};
}

// Help, allowed values and the value that is used when the argument is not given, without a full stop.
std::string meaning(const Argument& a) {
    const std::string_view not_given = a.standard.empty() ? a.otherwise : a.standard;
    return fmt::format("{}{}{}", a.help, allowed(a),
                       not_given.empty() ? "" : fmt::format(" [{}]", not_given));
}

// Positional arguments: "FILE".
std::string positional_names(const Command& command) {
    std::string names;
    for (const Argument& a : command.arguments)
        if (a.positional()) names += fmt::format("{}{}", names.empty() ? "" : " ", a.name);
    return names;
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

/// Text of a manual page in the macros of man(7). Line ends in the texts count as blanks.
class ManualPage {
public:
    /// name: "shakerctl"; number: part of the manual, 1 or 8; what: one line without a full stop.
    ManualPage(std::string_view name, int number, std::string_view what);

    void section(std::string_view title);
    void paragraph(std::string_view text);
    /// A command line: `name` in bold, then `rest`.
    void call(std::string_view name, std::string_view rest);
    /// A term in bold, then its value in italics, then its meaning.
    void item(std::string_view term, std::string_view value, std::string_view meaning);
    /// Indents everything until leave(): it belongs to the item above.
    void enter();
    void leave();
    /// Lines that are not filled.
    void example(std::string_view lines);

    [[nodiscard]] const std::string& text() const noexcept { return text_; }

private:
    void begin();

    std::string text_;
    bool fresh_ = false;  // the last call was section()
};

// Writes hyphens so that the page shows them as typed.
std::string spelled(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else if (c == '^')
            out += "\\(ha";
        else if (c == '~')
            out += "\\(ti";
        else
            out += c;
    }
    return out;
}

// Protects the first character of a line that would otherwise be read as a request.
std::string guarded(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) out += "\\&";
        out += c;
    }
    return out;
}

std::string escaped(std::string_view text) { return guarded(spelled(text)); }

constexpr std::size_t line_width = 80;

std::string capitals(std::string_view text) {
    std::string out{text};
    std::ranges::transform(out, out.begin(), [](unsigned char c) { return std::toupper(c); });
    return out;
}

std::string body(std::string_view text) { return guarded(filled(spelled(text), line_width)) + "\n"; }

ManualPage::ManualPage(std::string_view name, int number, std::string_view what)
    : text_{fmt::format(".TH {} {} \"{}\" \"shakerd " SHAKER_VERSION "\"\n.SH NAME\n{} \\- {}\n",
                        capitals(name), number, SHAKER_DATE, escaped(name), escaped(what))} {}

void ManualPage::section(std::string_view title) {
    text_ += fmt::format(".SH {}\n", escaped(title));
    fresh_ = true;
}

// The first paragraph after a title needs no request.
void ManualPage::begin() {
    if (!fresh_) text_ += ".PP\n";
    fresh_ = false;
}

void ManualPage::paragraph(std::string_view text) {
    begin();
    text_ += body(text);
}

void ManualPage::call(std::string_view name, std::string_view rest) {
    begin();
    text_ += fmt::format("\\fB{}\\fP {}", escaped(name), body(rest));
}

void ManualPage::item(std::string_view term, std::string_view takes, std::string_view meaning) {
    text_ += fmt::format(".TP\n\\fB{}\\fP", escaped(term));
    if (!takes.empty()) text_ += fmt::format(" \\fI{}\\fP", escaped(takes));
    text_.append("\n").append(body(meaning));
    fresh_ = false;
}

void ManualPage::enter() { text_ += ".RS\n"; }

void ManualPage::leave() { text_ += ".RE\n"; }

void ManualPage::example(std::string_view lines) {
    begin();
    text_ += ".RS\n.EX\n" + escaped(lines);
    if (!lines.ends_with('\n')) text_ += '\n';
    text_ += ".EE\n.RE\n";
}

void add(ManualPage& page, std::span<const Argument> arguments) {
    for (const Argument& a : arguments) {
        const std::string name{a.name};
        page.item(a.letter == 0 ? name : fmt::format("-{}, {}", a.letter, name), value_name(a),
                  meaning(a) + ".");
    }
}

void add(ManualPage& page, const Program& program, const Command& command) {
    page.item(command.name, positional_names(command), sentences(command));
    page.enter();
    add(page, command.arguments);
    std::string statuses;
    for (const ExitStatus& s : program.exit_statuses)
        if (may_end_with(command, s)) statuses += fmt::format("{}{}", statuses.empty() ? "" : ", ", s.number);
    page.paragraph(fmt::format("Exit status: {}.", statuses));
    if (!command.example.empty()) page.example(command.example);
    page.leave();
}

void add(ManualPage& page, const Section& section) {
    page.section(section.title);
    if (!section.paragraph.empty()) page.paragraph(section.paragraph);
    for (const auto& [term, meaning] : section.items) page.item(term, "", meaning);
    if (!section.example.empty()) page.example(section.example);
}

}  // namespace

std::string sentences(const Command& command) {
    return fmt::format("{}.{}{}", command.summary, command.details.empty() ? "" : " ", command.details);
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

std::string manual_page(const Program& program) {
    ManualPage page{program.name, program.manual_part, program.title};
    page.section("SYNOPSIS");
    page.call(program.name, program.synopsis);
    page.section("DESCRIPTION");
    page.paragraph(program.about);
    page.paragraph(program.notation);
    page.section("COMMANDS");
    for (const Command& command : program.commands) add(page, program, command);
    page.section("OPTIONS");
    page.paragraph("Every command takes these options; they may also stand before the command.");
    add(page, program.common);
    page.section("EXIT STATUS");
    for (const ExitStatus& status : program.exit_statuses)
        page.item(std::to_string(status.number), "", std::string{status.meaning} + ".");
    for (const Section& section : program.sections) add(page, section);
    return page.text();
}

}  // namespace shaker::manual
