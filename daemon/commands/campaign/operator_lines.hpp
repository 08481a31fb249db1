#pragma once
// Lines that an operator types on standard input while a command drives the bench.
#include <optional>
#include <string>

namespace shaker::commands {

/// Thread safety: one thread. Not with a terminal in raw mode.
class OperatorLines {
public:
    /// The next line without its end; empty when there is none yet. waits: until a line, the end of the input
    /// or a signal comes.
    std::optional<std::string> next(bool waits);
    /// The input has ended.
    [[nodiscard]] bool closed() const noexcept { return closed_; }

private:
    std::string text_;
    bool closed_ = false;
};

}  // namespace shaker::commands
