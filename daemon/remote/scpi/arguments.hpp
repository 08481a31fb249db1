#pragma once
// The values behind a header, read as the row of the table says.
#include <array>
#include <span>
#include <vector>

#include "daemon/remote/scpi/command.hpp"
#include "daemon/remote/scpi/parameter.hpp"
#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {

using Arguments = std::array<Argument, most_parameters>;

/// Takes the values up to the end of the unit; optional ones that did not come hold their DEFault.
/// Throws Error, its detail without the command's name: -103 -108 -109 and what read_element and to_argument
/// throw.
std::span<const Argument> read_arguments(Text& text, std::span<const Parameter> parameters, Arguments& into);

/// MIN, MAX or DEF behind the query of a number; false when nothing is there.
bool read_bound(Text& text, Bound& bound);

}  // namespace shaker::scpi
