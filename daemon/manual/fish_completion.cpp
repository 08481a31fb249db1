#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include "daemon/manual/completion.hpp"

namespace shaker::manual {

namespace {

std::string in_quotes(std::string_view text) {
    std::string out = "'";
    for (const char c : text) {
        if (c == '\'' || c == '\\') out += '\\';
        out += c;
    }
    return out + "'";
}

std::string option(const Argument& a) {
    std::string line = fmt::format(" -l {} -d {}", a.name.substr(2), in_quotes(a.help));
    if (a.letter != 0) line += fmt::format(" -s {}", a.letter);
    if (a.kind == Kind::file || a.kind == Kind::folder)
        line += a.bare ? " -F" : " -r -F";
    else if (a.kind != Kind::flag)
        line += " -x";
    return a.words.empty() ? line : line + " -a " + in_quotes(fmt::format("{}", fmt::join(a.words, " ")));
}

std::string positional(const Argument& a) {
    if (a.kind == Kind::file || a.kind == Kind::folder) return " -F";
    return " -a " + in_quotes(fmt::format("{}", fmt::join(a.words, " ")));
}

}  // namespace

std::string fish_completion(const Program& program) {
    const std::string line = fmt::format("complete -c {}", program.name);
    std::string text = fmt::format("# fish completion of {}\n{} -f\n", program.name, line);
    for (const Argument& a : program.common) text += line + option(a) + "\n";
    for (const Command& command : program.commands)
        text += fmt::format("{} -n __fish_use_subcommand -a {} -d {}\n", line, command.name,
                            in_quotes(command.summary));
    for (const Command& command : program.commands)
        for (const Argument& a : command.arguments)
            text += fmt::format("{} -n '__fish_seen_subcommand_from {}'{}\n", line, command.name,
                                a.positional() ? positional(a) : option(a));
    return text;
}

}  // namespace shaker::manual
