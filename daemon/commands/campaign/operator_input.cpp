#include "daemon/commands/campaign/operator_input.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace shaker::commands {

OperatorInput::OperatorInput(Keys keys) : keys_{std::move(keys)} {
    termios now{};
    if (::isatty(STDIN_FILENO) != 1 || ::tcgetattr(STDIN_FILENO, &now) != 0) return;
    closed_ = ::tcgetpgrp(STDIN_FILENO) != ::getpgrp();
    if (closed_) return;
    before_ = now;
    now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    ::tcsetattr(STDIN_FILENO, TCSANOW, &now);
}

OperatorInput::~OperatorInput() {
    if (before_) ::tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
}

std::optional<std::string> OperatorInput::word_in_text() {
    if (keys()) {
        if (text_.empty()) return std::nullopt;
        const char key = text_.front();
        text_.erase(0, 1);
        const auto known = std::ranges::find(keys_, key, &std::pair<char, std::string>::first);
        return known == keys_.end() ? std::string{key} : known->second;
    }
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return line;
}

std::optional<std::string> OperatorInput::next(bool waits) {
    for (;;) {
        if (auto word = word_in_text()) return word;
        if (closed_) return std::nullopt;
        pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        if (poll(&input, 1, waits ? -1 : 0) <= 0) return std::nullopt;
        std::array<char, 256> some{};
        const ssize_t n = read(STDIN_FILENO, some.data(), some.size());
        if (n <= 0)
            closed_ = true;
        else
            text_.append(some.data(), static_cast<std::size_t>(n));
    }
}

}  // namespace shaker::commands
