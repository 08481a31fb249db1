#include "daemon/manual_command.hpp"

#include <algorithm>

#include "daemon/exit_status.hpp"
#include "daemon/manual/page.hpp"

namespace shaker {

namespace {

// "TEXT:{csv,mat}" as "csv|mat", "INT:INT in [2 - 9]" as "INT"; empty for a flag.
std::string value_of(const CLI::Option& option) {
    if (option.get_expected_max() == 0) return {};
    std::string type = option.get_type_name();
    if (const auto brace = type.find(":{"); brace != std::string::npos) {
        type = type.substr(brace + 2, type.rfind('}') - brace - 2);
        std::ranges::replace(type, ',', '|');
        return type;
    }
    return type.substr(0, type.find(':'));
}

void add(ManualPage& page, const CLI::Option& option) {
    const bool placed = !option.nonpositional();
    std::string meaning = option.get_description();
    if (const std::string otherwise = option.get_default_str(); !otherwise.empty() && otherwise != "\"\"")
        meaning += " [" + otherwise + "]";
    std::string name = placed ? option.get_name() : option.get_name(false, true);
    if (const auto comma = name.find(','); comma != std::string::npos) name.insert(comma + 1, " ");
    page.item(name, placed ? "" : value_of(option), meaning + ".");
}

void add(ManualPage& page, const CLI::App& command) {
    page.item(command.get_name(), "", command.get_description() + ".");
    page.enter();
    for (const CLI::Option* option : command.get_options())
        if (option != command.get_help_ptr()) add(page, *option);
    if (const std::string footer = command.get_footer(); !footer.empty()) page.paragraph(footer);
    page.leave();
}

}  // namespace

std::string manual_of(const CLI::App& app) {
    ManualPage page{"shakerd", 8, "shaker controller and data acquisition for vibration transport"};
    page.section("SYNOPSIS");
    page.call("shakerd", "COMMAND [OPTIONS]");
    page.section("DESCRIPTION");
    page.paragraph(app.get_description());
    page.paragraph(
        "Quantities carry units: 1.5g, 14.7m/s^2, 35deg, 0.61rad, 20Hz; a bare number is SI; g is 9.8 "
        "m/s^2.");
    page.section("COMMANDS");
    for (const CLI::App* command :
         app.get_subcommands([](const CLI::App* c) { return !c->get_group().empty(); }))
        add(page, *command);
    page.section("OPTIONS");
    page.paragraph("Of the program and, but for the version, of each command:");
    for (const CLI::Option* option : app.get_options()) add(page, *option);
    page.section("EXIT STATUS");
    for (const ExitMeaning& status : exit_meanings)
        page.item(std::to_string(status.number), "", std::string{status.meaning} + ".");
    page.section("FILES");
    page.item("/etc/shakerd/shakerd.toml", "", "Settings of the daemon as the service starts it.");
    page.item("/var/lib/shakerd", "", "Its recordings.");
    page.item("RUN.nxs", "",
              "A recording (HDF5, NeXus). While it grows it is RUN.nxs.part, with RUN.nxs.journal; "
              "pictures lie in RUN.frames. What a crash leaves of these \"recover\" finishes.");
    page.item("trip-TIME.nxs", "",
              "The last seconds of a run that a limit stopped and that was not recorded.");
    page.section("SIGNALS");
    page.item("SIGTERM, SIGINT", "",
              "\"serve\" brings the drive down softly, finishes what is recorded and ends.");
    page.item("SIGKILL", "",
              "Behind the drive always lies a ramp to zero that each write replaces: the DAC plays it "
              "out. What was recorded so far is in the .part file.");
    page.section("NOTES");
    page.paragraph("Software is not the emergency stop.");
    page.section("SEE ALSO");
    page.paragraph("shakerctl(1)");
    return page.text();
}

}  // namespace shaker
