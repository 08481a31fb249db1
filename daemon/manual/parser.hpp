#pragma once
// Reads a command line by a program's tables.
#include <string>

#include "daemon/manual/values.hpp"

namespace shaker::manual {

struct ParsedLine {
    const Command* command = nullptr;  // null: the command line only requests `text`
    Values values{};
    std::string text{};  // help or version, to be printed instead of running the command
};

/// Throws InputError for anything that the tables do not allow. The message names the argument, the value and
/// the allowed values or range. `program` outlives the result.
ParsedLine parse(const Program& program, int argc, const char* const* argv);

}  // namespace shaker::manual
