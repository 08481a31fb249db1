#include "daemon/manual/completion.hpp"

#include "drivers/errors.hpp"

namespace shaker::manual {

std::string completion(const Program& program, std::string_view shell) {
    if (shell == "bash") return bash_completion(program);
    if (shell == "zsh") return zsh_completion(program);
    if (shell == "fish") return fish_completion(program);
    throw InputError{"completion \"" + std::string{shell} + "\": expected bash, zsh or fish"};
}

}  // namespace shaker::manual
