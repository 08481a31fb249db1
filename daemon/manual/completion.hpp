#pragma once
// Shell completion of a program's commands, options and values, made from its tables.
#include <array>
#include <string>
#include <string_view>

#include "daemon/manual/command.hpp"

namespace shaker::manual {

inline constexpr std::array<std::string_view, 3> shells{"bash", "zsh", "fish"};

/// The script for `shell`; InputError when it is not one of `shells`.
std::string completion(const Program& program, std::string_view shell);

std::string bash_completion(const Program& program);
std::string zsh_completion(const Program& program);
std::string fish_completion(const Program& program);

}  // namespace shaker::manual
