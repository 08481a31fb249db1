#pragma once
// The commands of a program as data: parsing, help and manual page are made from these tables. Exit statuses:
// the form in which each program lists its own, those of shakerd, and their place in error handling.
#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string_view>

#include "drivers/quantity.hpp"

namespace shaker::manual {

struct ExitStatus {
    int number;
    std::string_view meaning;
    bool of_every_command = false;  // false: only of the commands whose rows list it
};

inline constexpr int exit_ok = 0;
inline constexpr int exit_failure = 1;  // an error that should not happen
// Command line, settings or a file's content; or data that cannot be reduced.
inline constexpr int exit_input = 2;
inline constexpr int exit_device = 3;         // a device or the disk failed
inline constexpr int exit_tripped = 5;        // a limit stopped the drive
inline constexpr int exit_signal = 128;       // plus the number of the signal that ended a run softly
inline constexpr int exit_not_identical = 4;  // replay: the results are not the recorded ones

/// The exit statuses of shakerd.
inline constexpr std::array exit_meanings{
    ExitStatus{exit_ok, "done", true},
    ExitStatus{exit_failure, "internal failure", true},
    ExitStatus{exit_input, "input refused, nothing was written; or the measured data cannot be reduced",
               true},
    ExitStatus{exit_device, "a device or the disk failed"},
    ExitStatus{exit_not_identical,
               "replay: the results differ from the recorded ones; recover: a finished file was changed"},
    ExitStatus{exit_tripped, "a limit stopped the drive"},
    ExitStatus{exit_signal, "plus the signal's number: a signal ended the run; the drive was stopped softly"},
};

/// Returns the result of `work`, or the status for the exception that it throws; logs the exception's
/// message.
int exit_status_of(const std::function<int()>& work);

class Values;

enum class Kind {
    flag,  // takes no value
    text,
    file,
    folder,
    word,      // one of `words`
    whole,     // a whole number in `allowed`
    quantity,  // a number with a unit, in `allowed`
};

/// An option or a positional argument.
struct Argument {
    std::string_view name;  // "--gamma"; a positional argument has no dashes: "FILE"
    char letter = 0;        // short form: 'o' for -o; 0: none
    /// Name of the value in help: "ACCELERATION"; empty: no value, or the list of words.
    std::string_view value{};
    std::string_view help{};  // one line without its full stop
    Kind kind = Kind::flag;
    std::span<const std::string_view> words{};
    Dimension dimension{};         // of a quantity
    Range allowed{};               // of a quantity (SI units) or of a whole number; both ends included
    std::string_view standard{};   // value that is used when the argument is not given; empty: none
    std::string_view otherwise{};  // describes a default that is not a fixed value: "as last"
    bool many = false;             // takes several values
    char separator = 0;            // between several values in one word; 0: none
    bool bare = false;             // the value may be left out
    bool must_exist = false;       // of a file or folder
    [[nodiscard]] constexpr bool positional() const { return !name.starts_with('-'); }
};

/// An option with a number and its unit.
constexpr Argument quantity_option(std::string_view name, std::string_view value, Dimension dimension,
                                   Range allowed, std::string_view help, std::string_view standard = {},
                                   std::string_view otherwise = {}) {
    return {.name = name,
            .value = value,
            .help = help,
            .kind = Kind::quantity,
            .dimension = dimension,
            .allowed = allowed,
            .standard = standard,
            .otherwise = otherwise};
}

/// An option with a whole number.
constexpr Argument whole_option(std::string_view name, std::string_view value, Range allowed,
                                std::string_view help, std::string_view standard = {},
                                std::string_view otherwise = {}) {
    Argument whole = quantity_option(name, value, {}, allowed, help, standard, otherwise);
    whole.kind = Kind::whole;
    return whole;
}

/// One row of the table.
struct Command {
    std::string_view name;
    std::string_view summary;               // a sentence without its full stop
    std::string_view details{};             // further sentences, or empty
    std::span<const Argument> arguments{};  // besides those that every command takes
    std::string_view example{};             // a command line
    std::array<int, 5> exit_statuses{};     // besides those of every command; unused places are 0
    int (*act)(const Values&) = nullptr;    // returns the exit status
};

/// A section of the manual page: a paragraph, then terms with their meaning, then lines of an example.
struct Section {
    std::string_view title;
    std::string_view paragraph{};
    std::span<const std::array<std::string_view, 2>> items{};
    std::string_view example{};
};

struct Program {
    std::string_view name;
    int manual_part;            // 1 or 8
    std::string_view title;     // one line without its full stop
    std::string_view synopsis;  // words behind the name
    std::string_view about;     // sentences
    std::string_view notation;  // sentences: how values are written
    std::span<const Command> commands;
    std::span<const Argument> common;  // options that every command takes
    std::span<const ExitStatus> exit_statuses;
    std::span<const Section> sections{};  // of the manual page, after those made from the tables
};

inline constexpr Argument help_option{.name = "--help", .letter = 'h', .help = "Print this help and exit"};
inline constexpr Argument version_option{.name = "--version", .help = "Print the version and exit"};

/// Arguments of several arrays, in this order.
template <std::size_t... N>
constexpr auto joined(const std::array<Argument, N>&... parts) {
    std::array<Argument, (N + ...)> all{};
    std::size_t at = 0;
    const auto add = [&](const auto& part) {
        for (const Argument& a : part) all[at++] = a;
    };
    (add(parts), ...);
    return all;
}

/// The command with this name; null if no command has it.
const Command* find(const Program& program, std::string_view name);

/// True when the command may end with this status.
bool may_end_with(const Command& command, const ExitStatus& status);

}  // namespace shaker::manual
