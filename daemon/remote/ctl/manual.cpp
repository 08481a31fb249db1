#include "daemon/remote/ctl/manual.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/manual/page.hpp"
#include "daemon/remote/ctl/table.hpp"
#include "daemon/remote/ctl/trouble.hpp"

namespace shaker::ctl {

namespace {

std::string places_of(const Command& command) {
    std::string places;
    for (const Argument& a : command.arguments)
        if (a.placed()) places += (places.empty() ? "" : " ") + a.name;
    return places;
}

// What it takes besides what its help says: the words, or the range.
std::string allowed(const Argument& a) {
    if (a.kind == Kind::quantity || a.kind == Kind::whole) {
        const bool bare = a.kind == Kind::whole || a.dimension == Dimension::ratio;
        return fmt::format(". From {:.7g} to {:.7g}{}", a.allowed.min, a.allowed.max,
                           bare ? "" : ", in SI units");
    }
    if (!a.placed() || a.words.size() <= 4) return {};
    std::string words;
    for (const std::string& word : a.words) words += (words.empty() ? ": " : ", ") + word;
    return words;
}

void add(ManualPage& page, const std::vector<Argument>& arguments) {
    for (const Argument& a : arguments) page.item(a.name, a.value, a.help + allowed(a) + ".");
}

}  // namespace

std::string manual() {
    ManualPage page{"shakerctl", 1, "commands to a shaker bench on call"};
    page.section("SYNOPSIS");
    page.call("shakerctl", "[--at URL] [--token-file FILE] COMMAND [ARGUMENTS]");
    page.section("DESCRIPTION");
    page.paragraph(
        "shakerctl asks the daemon \"shakerd serve\" for what it knows and gives it orders, one a call, for "
        "shells and scripts. Each call is a client of its own that takes no control for longer than its "
        "order: while a page or another client holds control, orders are refused and the answer names "
        "the holder. An abort is obeyed whoever holds control.");
    page.paragraph(
        "Quantities carry units: 1.5g, 14.7m/s^2, 35deg, 0.61rad, 20Hz, 500ms; a bare number is SI; g is "
        "9.8 m/s^2. Control characters in what the daemon says are shown as \\x1b, not obeyed.");
    page.section("COMMANDS");
    for (const Command& command : commands()) {
        page.item(command.name, places_of(command), sentences(command));
        if (command.arguments.empty()) continue;
        page.enter();
        add(page, command.arguments);
        page.leave();
    }
    page.section("OPTIONS");
    page.paragraph("They may stand before the command or behind it.");
    add(page, common_arguments());
    page.section("EXIT STATUS");
    for (const ExitStatus& status : exit_statuses)
        page.item(std::to_string(status.number), "", std::string{status.meaning} + ".");
    page.section("ENVIRONMENT");
    page.item("SHAKERD_URL", "", "Where the daemon is, unless --at says it.");
    page.item("SHAKERD_TOKEN", "", "The daemon's token, unless --token-file names a file with it.");
    page.section("NOTES");
    page.paragraph(
        "A daemon has 5 s to answer, 2 s an abort. An order that was not answered may have been done: status "
        "says. The name of a machine is looked up by the system, which "
        "may take longer: where an abort must not wait for that, give its number. Software is not the "
        "emergency stop.");
    page.section("EXAMPLES");
    page.example(
        "shakerctl set --gamma 1.5g --phi 35deg\n"
        "shakerctl record on --name series-1\n"
        "shakerctl start --periods 40 --wait && shakerctl fetch result >result.json\n"
        "shakerctl stop --wait\n"
        "shakerctl watch --json | jq -r 'select(.type == \"event\").text'\n");
    page.section("SEE ALSO");
    page.paragraph("shakerd(8)");
    return page.text();
}

}  // namespace shaker::ctl
