#pragma once
// Words that an operator gives while a command drives the bench: keys of a terminal, or lines of another
// standard input.
#include <termios.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace shaker::commands {

/// A key and the word for which it stands.
using Keys = std::vector<std::pair<char, std::string>>;

/// On a terminal each key acts at once, without an echo, during the life of this object. A program in the
/// background of a terminal has no input. Thread safety: one thread.
class OperatorInput {
public:
    explicit OperatorInput(Keys keys);
    ~OperatorInput();
    OperatorInput(const OperatorInput&) = delete;
    OperatorInput& operator=(const OperatorInput&) = delete;

    /// Returns the next word, or nothing when none has come yet. With `waits` it first waits until a word,
    /// the end of the input or a signal comes.
    std::optional<std::string> next(bool waits);
    /// The input has ended.
    [[nodiscard]] bool closed() const noexcept { return closed_; }
    /// Standard input is a terminal.
    [[nodiscard]] bool keys() const noexcept { return before_.has_value(); }

private:
    std::optional<std::string> word_in_text();

    Keys keys_;
    std::optional<termios> before_;  // of the terminal
    std::string text_;
    bool closed_ = false;
};

}  // namespace shaker::commands
