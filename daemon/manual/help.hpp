#pragma once
// Help texts and the manual page of a program, made from its tables.
#include <string>

#include "daemon/manual/command.hpp"

namespace shaker::manual {

/// Output of "PROGRAM --help", or of "PROGRAM COMMAND --help" with a command. Lines have at most 100 columns.
std::string help(const Program& program, const Command* command = nullptr);

/// The manual page, in the macros of man(7).
std::string manual_page(const Program& program);

/// Summary and details, in full sentences.
std::string sentences(const Command& command);

}  // namespace shaker::manual
