#pragma once
// What an operator reads while a campaign is measured, and the words that the operator gives meanwhile: keys
// of a terminal, or lines of another standard input.
#include <termios.h>

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/service/bench_port.hpp"

namespace shaker::commands {

/// One line for each point that ends, each pause and each problem, at once, also into a pipe; trips and
/// warnings of the bench go to the log. On a terminal there is a last line that is written again and again:
/// point, what the bench does, time left.
class CampaignLines {
public:
    /// The port must outlive this object. to: standard output, or standard error where that has JSON.
    CampaignLines(const service::BenchPort& port, std::FILE* to);
    ~CampaignLines();
    CampaignLines(const CampaignLines&) = delete;
    CampaignLines& operator=(const CampaignLines&) = delete;

    /// Writes what is new.
    void follow();
    /// An answer to the operator.
    void say(const std::string& sentence);

private:
    void status(const service::CampaignState& campaign);

    const service::BenchPort& port_;
    std::FILE* to_;
    bool terminal_;
    std::uint64_t seen_ = 0;  // number of the newest event
    double written_s_ = -1;   // monotonic time of the last line
};

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
