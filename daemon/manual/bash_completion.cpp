#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <map>
#include <set>

#include "daemon/manual/completion.hpp"

namespace shaker::manual {

namespace {

using Names = std::set<std::string>;

// %N: the program, %V: common options with a value, %F, %D, %O: options with a file, a folder, another value,
// %P: commands whose positional argument is a file, %L: words allowed for an option, %C: commands and common
// options, %W: words behind each command.
constexpr std::string_view script = R"(# bash completion of %N
_%N() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command='' words='' i
    for ((i = 1; i < COMP_CWORD; i++)); do
        case ${COMP_WORDS[i]} in
        %V) ((i++)) ;;
        -*) ;;
        *) command=${COMP_WORDS[i]}; break ;;
        esac
    done
    COMPREPLY=()
    case "$command $before" in
    %F)
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
        return ;;
    %D)
        mapfile -t COMPREPLY < <(compgen -d -- "$word")
        return ;;
    %O) return ;;
%L    *)
        case $command in
        '') words='%C' ;;
%W        esac ;;
    esac
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
    case "$command $word" in
    *' -'*) ;;
    %P) mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -f -- "$word") ;;
    esac
}
complete -o filenames -F _%N %N
)";

std::string pattern(const Names& names) {
    return names.empty() ? "'no such word'" : fmt::format("{}", fmt::join(names, "|"));
}

std::string filled_in(const std::map<char, std::string>& parts) {
    std::string text;
    for (std::size_t i = 0; i < script.size(); ++i) {
        const auto part = script[i] == '%' ? parts.find(script[i + 1]) : parts.end();
        if (part == parts.end()) {
            text += script[i];
        } else {
            text += part->second;
            ++i;
        }
    }
    return text;
}

// Patterns "command option" of the options with a value, by the kind of the value.
struct Patterns {
    Names files, folders, others;

    void add(const std::string& command, const Argument& a) {
        Names& names = a.kind == Kind::file ? files : a.kind == Kind::folder ? folders : others;
        for (const std::string& spelling : spellings(a))
            names.insert(command.empty() ? "*' " + spelling + "'" : "'" + command + " " + spelling + "'");
    }
    static std::vector<std::string> spellings(const Argument& a) {
        std::vector<std::string> all{std::string{a.name}};
        if (a.letter != 0) all.push_back({'-', a.letter});
        return all;
    }
};

}  // namespace

std::string bash_completion(const Program& program) {
    Patterns patterns;
    Names valued, positional_files;
    std::string lists, words, first;
    for (const Argument& a : program.common) {
        if (a.kind == Kind::flag) continue;
        valued.insert(std::string{a.name});
        patterns.add("", a);
    }
    for (const Command& command : program.commands) {
        const std::string name{command.name};
        std::vector<std::string_view> own;
        for (const Argument& a : command.arguments) {
            if (a.positional())
                own.insert(own.end(), a.words.begin(), a.words.end());
            else
                own.push_back(a.name);
            if (a.positional() && a.kind == Kind::file) positional_files.insert("'" + name + " '*");
            if (a.positional() || a.kind == Kind::flag) continue;
            if (a.words.empty())
                patterns.add(name, a);
            else
                lists += fmt::format("    '{} {}') words='{}' ;;\n", name, a.name, fmt::join(a.words, " "));
        }
        for (const Argument& a : program.common) own.push_back(a.name);
        words += fmt::format("        {}) words='{}' ;;\n", name, fmt::join(own, " "));
        first += name + " ";
    }
    for (const Argument& a : program.common) first += std::string{a.name} + " ";
    first.pop_back();
    return filled_in({{'N', std::string{program.name}},
                      {'V', pattern(valued)},
                      {'F', pattern(patterns.files)},
                      {'D', pattern(patterns.folders)},
                      {'O', pattern(patterns.others)},
                      {'P', pattern(positional_files)},
                      {'L', lists},
                      {'C', first},
                      {'W', words}});
}

}  // namespace shaker::manual
