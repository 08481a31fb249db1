#pragma once
// The values of a command line, checked against the command's table.
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/manual/command.hpp"

namespace shaker::manual {

/// Names that are not in the table are an error of the program (std::logic_error).
class Values {
public:
    Values() = default;
    Values(const Program& program, const Command& command) : program_{&program}, command_{&command} {}

    /// Adds the texts given for an argument; none for a flag. InputError when a text is not allowed, naming
    /// the argument, the text and what is allowed.
    void add(const Argument& argument, std::vector<std::string> texts);

    /// True when the argument was given.
    [[nodiscard]] bool has(std::string_view name) const;
    /// The text that was given, else the standard value, else empty.
    [[nodiscard]] std::string text(std::string_view name) const;
    /// All texts that were given, else the standard value, else none.
    [[nodiscard]] std::vector<std::string> texts(std::string_view name) const;
    /// A quantity in SI units. The argument was given or has a standard value.
    [[nodiscard]] double number(std::string_view name) const;
    /// A whole number. The argument was given or has a standard value.
    [[nodiscard]] int whole(std::string_view name) const;

private:
    [[nodiscard]] const Argument& argument(std::string_view name) const;

    const Program* program_ = nullptr;
    const Command* command_ = nullptr;
    std::map<std::string, std::vector<std::string>, std::less<>> given_;
};

}  // namespace shaker::manual
