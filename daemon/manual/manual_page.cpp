#include "daemon/manual/manual_page.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/manual/help.hpp"
#include "daemon/manual/page.hpp"

namespace shaker::manual {

namespace {

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
