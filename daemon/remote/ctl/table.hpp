#pragma once
// The commands of shakerctl as one table: the command line, its help, the completions and the manual page are
// made from it.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "daemon/remote/ctl/link.hpp"
#include "drivers/quantity.hpp"

namespace shaker::ctl {

enum class Kind { flag, text, file, word, whole, quantity };

struct Argument {
    std::string name;   // "--gamma"; one without dashes has its place behind the command: "STATE"
    std::string value;  // how help calls what it takes: "S"; empty for a flag and for a place
    std::string help;
    Kind kind = Kind::flag;
    std::vector<std::string> words{};  // of Kind::word
    Dimension dimension{};             // of Kind::quantity
    Range allowed{};                   // of a quantity, SI, or of a whole number
    [[nodiscard]] bool placed() const { return !name.starts_with('-'); }
};

/// What was typed, checked against the table.
struct Given {
    std::map<std::string, std::string> texts;  // "--gamma" to "1g"; a flag to ""
    std::map<std::string, double> numbers;     // quantities in SI, and whole numbers

    [[nodiscard]] bool has(const std::string& name) const { return texts.contains(name); }
    /// Empty where it was not typed.
    [[nodiscard]] std::string text(const std::string& name) const;
    /// Of one that was typed.
    [[nodiscard]] double number(const std::string& name) const { return numbers.at(name); }
};

struct Command {
    std::string name;
    std::string help;  // a sentence without its full stop
    std::string more;  // further sentences, without the last full stop; or empty
    std::vector<Argument> arguments;
    std::function<void(const Given&)> act;  // throws InputError and what trouble.hpp has
};

/// Help and what more there is to say.
std::string sentences(const Command& command);

const std::vector<Command>& commands();
/// Those that every command takes.
const std::vector<Argument>& common_arguments();

/// The daemon that was asked for: --at or SHAKERD_URL, --token-file or SHAKERD_TOKEN.
Link link_of(const Given& given);

}  // namespace shaker::ctl
