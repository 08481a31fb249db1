#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include "daemon/manual/completion.hpp"

namespace shaker::manual {

namespace {

std::string in_quotes(std::string_view text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? "'\\''" : std::string{c};
    return out + "'";
}

// Colons and brackets have a meaning in a specification of _arguments.
std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c == ':' || c == '[' || c == ']') out += '\\';
        out += c;
    }
    return out;
}

std::string values(const Argument& a) {
    if (a.kind == Kind::file) return "_files";
    if (a.kind == Kind::folder) return "_files -/";
    return a.words.empty() ? "" : fmt::format("({})", fmt::join(a.words, " "));
}

std::string specification(const Argument& a, const std::string& name) {
    const std::string option = fmt::format("{}{}[{}]", a.many ? "*" : "", name, escaped(a.help));
    if (a.kind == Kind::flag) return in_quotes(option);
    return in_quotes(fmt::format("{}:{}{}:{}", option, a.bare ? ":" : "", a.value, values(a)));
}

// One specification per spelling of the option.
std::string specifications(const Argument& a, const char* between) {
    if (a.positional()) return between + in_quotes(fmt::format(":{}:{}", escaped(a.help), values(a)));
    std::string text = between + specification(a, std::string{a.name});
    if (a.letter != 0) text += between + specification(a, {'-', a.letter});
    return text;
}

}  // namespace

std::string zsh_completion(const Program& program) {
    std::string list, cases, common;
    for (const Argument& a : program.common) common += specifications(a, " \\\n        ");
    for (const Command& command : program.commands) {
        list += fmt::format("        {}\n", in_quotes(fmt::format("{}:{}", command.name, command.summary)));
        cases += fmt::format("        {}) _arguments $common", command.name);
        for (const Argument& a : command.arguments) cases += specifications(a, " \\\n            ");
        cases += " ;;\n";
    }
    return fmt::format(R"(#compdef {0}
_{0}() {{
    local curcontext=$curcontext state line
    local -a commands common
    commands=(
{1}    )
    common=({2})
    _arguments -C $common '1: :->command' '*:: :->arguments' && return
    case $state in
    command) _describe command commands ;;
    arguments)
        case $line[1] in
{3}        esac ;;
    esac
}}
if [ "$funcstack[1]" = _{0} ]; then
    _{0} "$@"
else
    compdef _{0} {0}
fi
)",
                       program.name, list, common, cases);
}

}  // namespace shaker::manual
