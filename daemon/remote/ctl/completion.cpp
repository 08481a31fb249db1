#include "daemon/remote/ctl/completion.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/remote/ctl/table.hpp"
#include "drivers/errors.hpp"

namespace shaker::ctl {

namespace {

std::string joined(const std::vector<std::string>& words) {
    std::string line;
    for (const std::string& word : words) line += (line.empty() ? "" : " ") + word;
    return line;
}

// In single quotes, for all three shells.
std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? "'\\''" : std::string{c};
    return out + "'";
}

std::string command_names() {
    std::vector<std::string> names;
    for (const Command& command : commands()) names.push_back(command.name);
    return joined(names);
}

// A row's own arguments and those of every command.
std::vector<Argument> all_of(const Command& command) {
    std::vector<Argument> all = command.arguments;
    all.insert(all.end(), common_arguments().begin(), common_arguments().end());
    return all;
}

std::string for_bash() {
    std::string values, options;
    for (const Command& command : commands()) {
        std::vector<std::string> words;
        for (const Argument& a : all_of(command)) {
            if (a.placed())
                words.insert(words.end(), a.words.begin(), a.words.end());
            else
                words.push_back(a.name);
            if (!a.placed() && !a.words.empty())
                values +=
                    fmt::format("        '{} {}') words='{}' ;;\n", command.name, a.name, joined(a.words));
        }
        options += fmt::format("            {}) words='{}' ;;\n", command.name, joined(words));
    }
    std::string files, others, common, valued;
    for (const Command& command : commands()) {
        for (const Argument& a : all_of(command)) {
            if (a.placed() || a.kind == Kind::flag) continue;
            std::string& list = a.kind == Kind::file ? files : others;
            if (a.words.empty() && ("|" + list + "|").find("|" + a.name + "|") == std::string::npos)
                list += (list.empty() ? "" : "|") + a.name;
        }
    }
    for (const Argument& a : common_arguments()) {
        common += " " + a.name;
        if (a.kind != Kind::flag) valued += (valued.empty() ? "" : "|") + a.name;
    }
    return "# bash completion of shakerctl\n"
           "_shakerctl() {\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command='' words='' "
           "i\n"
           "    for ((i = 1; i < COMP_CWORD; i++)); do\n"
           "        case ${COMP_WORDS[i]} in\n"
           "        " +
           valued +
           ") ((i++)) ;;\n"
           "        -*) ;;\n"
           "        *) command=${COMP_WORDS[i]}; break ;;\n"
           "        esac\n"
           "    done\n"
           "    COMPREPLY=()\n"
           "    case $before in\n"
           "    " +
           files +
           ")\n"
           "        mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
           "        return ;;\n"
           "    " +
           others +
           ") return ;;\n"
           "    esac\n"
           "    case \"$command $before\" in\n" +
           values +
           "        *)\n"
           "            case $command in\n"
           "            '') words='" +
           command_names() + common + "' ;;\n" + options +
           "            esac ;;\n"
           "    esac\n"
           "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
           "}\n"
           "complete -F _shakerctl shakerctl\n";
}

// A specification of _arguments: colons and brackets are its own.
std::string zsh_text(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == ':' || c == '[' || c == ']') out += '\\';
        out += c;
    }
    return out;
}

std::string zsh_specification(const Argument& a) {
    const std::string values = a.kind == Kind::file ? "_files"
                               : a.words.empty()    ? ""
                                                    : "(" + joined(a.words) + ")";
    if (a.placed()) return quoted(fmt::format(":{}:{}", zsh_text(a.help), values));
    const std::string option = a.name + "[" + zsh_text(a.help) + "]";
    return quoted(a.kind == Kind::flag ? option : fmt::format("{}:{}:{}", option, a.value, values));
}

std::string for_zsh() {
    std::string list, cases, common;
    for (const Argument& a : common_arguments()) common += " \\\n        " + zsh_specification(a);
    for (const Command& command : commands()) {
        list += "        " + quoted(command.name + ":" + command.help) + "\n";
        cases += "        " + command.name + ") _arguments $common";
        for (const Argument& a : command.arguments) cases += " \\\n            " + zsh_specification(a);
        cases += " ;;\n";
    }
    return "#compdef shakerctl\n"
           "_shakerctl() {\n"
           "    local curcontext=$curcontext state line\n"
           "    local -a commands common\n"
           "    commands=(\n" +
           list +
           "    )\n"
           "    common=(" +
           common +
           ")\n"
           "    _arguments -C $common '1: :->command' '*:: :->arguments' && return\n"
           "    case $state in\n"
           "    command) _describe command commands ;;\n"
           "    arguments)\n"
           "        case $line[1] in\n" +
           cases +
           "        esac ;;\n"
           "    esac\n"
           "}\n"
           "if [ \"$funcstack[1]\" = _shakerctl ]; then\n"
           "    _shakerctl \"$@\"\n"
           "else\n"
           "    compdef _shakerctl shakerctl\n"
           "fi\n";
}

std::string fish_text(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += (c == '\'' || c == '\\' ? "\\" : "") + std::string{c};
    return out + "'";
}

std::string fish_option(const Argument& a) {
    std::string line = " -l " + a.name.substr(2) + " -d " + fish_text(a.help);
    if (a.kind == Kind::file)
        line += " -r -F";
    else if (a.kind != Kind::flag)
        line += " -x";
    return a.words.empty() ? line : line + " -a " + fish_text(joined(a.words));
}

std::string for_fish() {
    std::string text = "# fish completion of shakerctl\ncomplete -c shakerctl -f\n";
    for (const Argument& a : common_arguments()) text += "complete -c shakerctl" + fish_option(a) + "\n";
    for (const Command& command : commands())
        text += "complete -c shakerctl -n __fish_use_subcommand -a " + command.name + " -d " +
                fish_text(command.help) + "\n";
    for (const Command& command : commands())
        for (const Argument& a : command.arguments)
            text += fmt::format("complete -c shakerctl -n '__fish_seen_subcommand_from {}'{}\n", command.name,
                                a.placed() ? " -a " + fish_text(joined(a.words)) : fish_option(a));
    return text;
}

}  // namespace

std::string completion(const std::string& shell) {
    if (shell == "bash") return for_bash();
    if (shell == "zsh") return for_zsh();
    if (shell == "fish") return for_fish();
    throw InputError{"completion \"" + shell + "\": bash, zsh or fish was expected"};
}

}  // namespace shaker::ctl
