#pragma once
// Help texts, made from a program's tables.
#include <string>

#include "daemon/manual/command.hpp"

namespace shaker::manual {

/// Output of "PROGRAM --help", or of "PROGRAM COMMAND --help" with a command. Lines have at most 100 columns.
std::string help(const Program& program, const Command* command = nullptr);

/// Name of the argument's value: "ACCELERATION", "off|region|full"; empty for flags and positional arguments.
std::string value_name(const Argument& argument);
/// Help, allowed values and the value that is used when the argument is not given, without a full stop.
std::string meaning(const Argument& argument);
/// Summary and details, in full sentences.
std::string sentences(const Command& command);
/// Positional arguments: "FILE".
std::string positional_names(const Command& command);

}  // namespace shaker::manual
