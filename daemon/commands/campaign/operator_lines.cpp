#include "daemon/commands/campaign/operator_lines.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>

namespace shaker::commands {

std::optional<std::string> OperatorLines::next(bool waits) {
    for (;;) {
        if (const std::size_t end = text_.find('\n'); end != std::string::npos) {
            std::string line = text_.substr(0, end);
            text_.erase(0, end + 1);
            return line;
        }
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
