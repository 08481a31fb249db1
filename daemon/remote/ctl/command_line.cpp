#include "daemon/remote/ctl/command_line.hpp"

#include <spdlog/fmt/fmt.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <list>
#include <sstream>

#include "daemon/manual/page.hpp"
#include "daemon/remote/ctl/table.hpp"
#include "daemon/remote/ctl/terminal.hpp"
#include "daemon/remote/ctl/trouble.hpp"
#include "drivers/errors.hpp"

namespace shaker::ctl {

namespace {

constexpr const char* about =
    "shakerctl asks the daemon \"shakerd serve\" for what it knows and gives it orders, for shells and "
    "scripts.\n";

constexpr std::size_t most_columns = 100;

std::string ending() {
    std::string text =
        "\nQuantities carry units: 1.5g, 14.7m/s^2, 35deg, 0.61rad, 20Hz, 500ms; a bare number is SI.\n"
        "Exit status:\n";
    for (const ExitStatus& s : exit_statuses) text += fmt::format("  {:>2}  {}\n", s.number, s.meaning);
    return text;
}

// What CLI11 fills while it reads the command line.
struct Words {
    const Argument* argument;
    CLI::Option* option;
    std::string text;
};

/// CLI11's view of the table.
class Reader {
public:
    Reader() {
        app_.footer(ending());
        app_.require_subcommand(1);
        app_.get_formatter()->column_width(34);
        for (const Argument& a : common_arguments()) {
            if (a.name == "--help")
                app_.set_help_flag("-h,--help", a.help);
            else if (a.name == "--version")
                app_.set_version_flag("--version", "shakerctl " SHAKER_VERSION, a.help);
            else
                add(app_, a);
        }
        for (const Command& command : commands()) {
            CLI::App& app = *app_.add_subcommand(command.name, command.help);
            app.fallthrough();
            if (!command.more.empty()) app.footer("\n" + filled(command.more, most_columns) + "." + ending());
            for (const Argument& a : command.arguments) add(app, a);
        }
    }

    CLI::App& app() { return app_; }

    /// Of the command line that was read.
    [[nodiscard]] Given given() const {
        Given given;
        for (const Words& w : words_) {
            if (w.option->count() == 0) continue;
            const Argument& a = *w.argument;
            given.texts[a.name] = w.text;
            if (a.kind == Kind::quantity)
                given.numbers[a.name] = parse_quantity(a.name, w.text, a.dimension, a.allowed);
            else if (a.kind == Kind::whole)
                given.numbers[a.name] = std::stod(w.text);
        }
        return given;
    }

    [[nodiscard]] const Command& command() const {
        const std::string name = app_.get_subcommands().at(0)->get_name();
        return *std::ranges::find(commands(), name, &Command::name);
    }

private:
    void add(CLI::App& app, const Argument& a) {
        Words& w = words_.emplace_back(Words{&a, nullptr, {}});
        if (a.kind == Kind::flag) {
            w.option = app.add_flag(a.name, a.help);
            return;
        }
        w.option = app.add_option(a.name, w.text, a.help)->required(a.placed());
        if (!a.value.empty()) w.option->type_name(a.value);
        if (a.kind == Kind::word) w.option->check(CLI::IsMember(a.words));
        if (a.kind == Kind::whole)
            w.option->check(CLI::Range(static_cast<int>(a.allowed.min), static_cast<int>(a.allowed.max)));
    }

    CLI::App app_{about, "shakerctl"};
    std::list<Words> words_;  // CLI11 keeps addresses of the texts
};

// "--gamma 3 bananas" without quotes: what is wrong with the quantity that was meant.
void refuse_split_quantity(const Command& command, int argc, const char* const* argv) {
    for (const Argument& a : command.arguments) {
        for (int i = 1; i + 2 < argc; ++i) {
            if (a.kind != Kind::quantity || a.name != argv[i] || argv[i + 2][0] == '-') continue;
            const std::string both = std::string{argv[i + 1]} + " " + argv[i + 2];
            parse_quantity(a.name, both, a.dimension, a.allowed);
            throw InputError{a.name + ": a value with a blank in it needs quotes: \"" + both + "\""};
        }
    }
}

void say(const std::string& what) { std::fputs(("shakerctl: " + printable(what) + "\n").c_str(), stderr); }

int act(int argc, const char* const* argv) {
    Reader reader;
    try {
        reader.app().parse(argc, argv);
    } catch (const CLI::Success& e) {
        std::ostringstream text;
        reader.app().exit(e, text, text);
        print(text.str());
        return exit_done;
    } catch (const CLI::ParseError& e) {
        const bool known = !reader.app().get_subcommands().empty();
        const bool unknown = !known && argc > 1 && argv[1][0] != '-';
        if (known && dynamic_cast<const CLI::ExtrasError*>(&e) != nullptr)
            refuse_split_quantity(reader.command(), argc, argv);
        throw InputError{(unknown ? fmt::format("\"{}\" is not a command", argv[1]) : std::string{e.what()}) +
                         "; shakerctl --help lists all"};
    }
    reader.command().act(reader.given());
    return exit_done;
}

}  // namespace

std::string help(const std::string& command) {
    Reader reader;
    return command.empty() ? reader.app().help() : reader.app().get_subcommand(command)->help();
}

int command_line(int argc, const char* const* argv) try { return act(argc, argv); } catch (const Refused& e) {
    say(e.what());
    return exit_refused;
} catch (const InputError& e) {
    say(e.what());
    return exit_wrong_use;
} catch (const NotReached& e) {
    say(e.what());
    return exit_not_reached;
} catch (const TimedOut& e) {
    say(e.what());
    return exit_timed_out;
} catch (const NotWritten& e) {
    if (nobody_reads()) return exit_done;
    say(e.what());
    return exit_not_written;
}

}  // namespace shaker::ctl
