#pragma once
// The manual page of a program, made from its tables.
#include <string>

#include "daemon/manual/command.hpp"

namespace shaker::manual {

/// In the macros of man(7).
std::string manual_page(const Program& program);

}  // namespace shaker::manual
