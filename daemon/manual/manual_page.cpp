#include "daemon/manual/manual_page.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cctype>

#include "daemon/manual/help.hpp"

namespace shaker::manual {

namespace {

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
