#pragma once
// The manual page of shakerd, made from its own command line.
#include <CLI/CLI.hpp>
#include <string>

namespace shaker {

/// shakerd(8) in the words of man(7): the commands and options of `app` as its help has them.
std::string manual_of(const CLI::App& app);

}  // namespace shaker
