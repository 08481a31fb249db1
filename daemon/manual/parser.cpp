#include "daemon/manual/parser.hpp"

#include <spdlog/fmt/fmt.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <list>

#include "daemon/manual/help.hpp"
#include "drivers/errors.hpp"

namespace shaker::manual {

namespace {

// The texts that CLI11 stores for one argument; it keeps their addresses.
struct Slot {
    const Argument* argument;
    CLI::Option* option = nullptr;
    std::string text{};
    std::vector<std::string> texts{};
};

std::string option_names(const Argument& a) {
    const std::string name{a.name};
    return a.letter == 0 ? name : std::string{'-', a.letter, ','} + name;
}

class Reader {
public:
    explicit Reader(const Program& program) : program_{program}, app_{"", std::string{program.name}} {
        app_.require_subcommand(1);
        app_.set_help_flag(option_names(help_option));
        app_.set_version_flag(option_names(version_option), "-");
        for (const Argument& a : program.common)
            if (a.name != help_option.name && a.name != version_option.name) add(app_, a);
        for (const Command& command : program.commands) {
            CLI::App& app = *app_.add_subcommand(std::string{command.name});
            app.fallthrough();
            for (const Argument& a : command.arguments) add(app, a);
        }
    }

    ParsedLine read(int argc, const char* const* argv) {
        try {
            app_.parse(argc, argv);
        } catch (const CLI::CallForHelp& e) {
            if (argc > 1 && argv[1][0] != '-' && command() == nullptr) refuse(e, argc, argv);
            return {.text = help(program_, command())};
        } catch (const CLI::CallForVersion&) {
            return {.text = fmt::format("{} " SHAKER_VERSION "\n", program_.name)};
        } catch (const CLI::ParseError& e) {
            refuse(e, argc, argv);
        }
        ParsedLine line{.command = command(), .values = {program_, *command()}};
        for (const Slot& slot : slots_) {
            if (slot.option->count() == 0) continue;
            std::vector<std::string> texts = slot.texts;
            if (!slot.text.empty() || needs_value(*slot.argument)) texts = {slot.text};
            if (slot.argument->many) texts = slot.texts;
            line.values.add(*slot.argument, std::move(texts));
        }
        return line;
    }

private:
    static bool needs_value(const Argument& a) { return a.kind != Kind::flag && !a.bare; }

    void add(CLI::App& app, const Argument& a) {
        Slot& slot = slots_.emplace_back(Slot{&a});
        if (a.kind == Kind::flag) {
            slot.option = app.add_flag(option_names(a));
            return;
        }
        slot.option =
            a.many ? app.add_option(option_names(a), slot.texts) : app.add_option(option_names(a), slot.text);
        slot.option->required(a.positional());
        if (a.separator != 0) slot.option->delimiter(a.separator);
        if (a.bare) slot.option->expected(0, 1);
    }

    [[nodiscard]] const Command* command() const {
        const auto parsed = app_.get_subcommands();
        return parsed.empty() ? nullptr : find(program_, parsed.front()->get_name());
    }

    [[noreturn]] void refuse(const CLI::ParseError& e, int argc, const char* const* argv) const {
        if (const Command* known = command(); known != nullptr) {
            if (dynamic_cast<const CLI::ExtrasError*>(&e) != nullptr)
                refuse_split_quantity(*known, argc, argv);
            throw InputError{fmt::format("{}; \"{} {} --help\" lists the arguments", reason(e), program_.name,
                                         known->name)};
        }
        std::string why = e.what();
        if (argc > 1 && argv[1][0] != '-')
            why = fmt::format("\"{}\" is not a command", argv[1]);
        else if (dynamic_cast<const CLI::RequiredError*>(&e) != nullptr)
            why = "expected a command";
        throw InputError{fmt::format("{}; \"{} --help\" lists the commands", why, program_.name)};
    }

    // CLI11's own message names several words in reverse order, or speaks of its types.
    [[nodiscard]] std::string reason(const CLI::ParseError& e) const {
        const std::string message = e.what();
        if (dynamic_cast<const CLI::ArgumentMismatch*>(&e) != nullptr)
            return message.substr(0, message.find(':')) + ": expected one value";
        const std::vector<std::string> extra = app_.remaining(true);
        if (dynamic_cast<const CLI::ExtrasError*>(&e) == nullptr || extra.empty()) return message;
        const auto option = std::ranges::find_if(extra, [](auto& word) { return word.starts_with('-'); });
        return fmt::format("\"{}\" was not expected", option == extra.end() ? extra.front() : *option);
    }

    // "--gamma 3 bananas" without quotes: reports the whole quantity.
    static void refuse_split_quantity(const Command& command, int argc, const char* const* argv) {
        for (const Argument& a : command.arguments) {
            for (int i = 1; i + 2 < argc; ++i) {
                if (a.kind != Kind::quantity || a.name != argv[i] || argv[i + 2][0] == '-') continue;
                const std::string both = std::string{argv[i + 1]} + " " + argv[i + 2];
                parse_quantity(a.name, both, a.dimension, a.allowed);
                throw InputError{
                    fmt::format("{}: a value with a blank in it needs quotes: \"{}\"", a.name, both)};
            }
        }
    }

    const Program& program_;
    CLI::App app_;
    std::list<Slot> slots_;
};

}  // namespace

ParsedLine parse(const Program& program, int argc, const char* const* argv) {
    return Reader{program}.read(argc, argv);
}

}  // namespace shaker::manual
