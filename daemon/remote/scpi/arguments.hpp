#pragma once
// Reads the values after a header according to the table of commands.
#include <array>
#include <span>
#include <vector>

#include "daemon/remote/scpi/command.hpp"
#include "daemon/remote/scpi/data/parameter.hpp"
#include "daemon/remote/scpi/data/text.hpp"

namespace shaker::scpi {

using Arguments = std::array<Argument, most_parameters>;

/// Reads the values up to the end of the unit; omitted optional values are set to their DEFault. Throws Error
/// without the command's name in its detail: -103 -108 -109, and those of read_element and to_argument.
std::span<const Argument> read_arguments(Text& text, std::span<const Parameter> parameters, Arguments& into);

/// Reads MIN, MAX or DEF after the query of a number; false without such a word.
bool read_bound(Text& text, Bound& bound);

}  // namespace shaker::scpi
