#include "daemon/remote/ctl/terminal.hpp"

#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "daemon/remote/ctl/trouble.hpp"

namespace shaker::ctl {

namespace {

struct Character {
    std::uint32_t code;
    std::size_t bytes;  // 0: invalid UTF-8
};

Character first_of(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned head = byte(0);
    if (head < 0x80) return {head, 1};
    const std::size_t bytes = head >= 0xf0 && head < 0xf5 ? 4 : head >= 0xe0 && head < 0xf0 ? 3 : 2;
    if (head < 0xc2 || head >= 0xf5 || text.size() < bytes) return {head, 0};
    std::uint32_t code = head & (0x7fU >> bytes);
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xc0U) != 0x80) return {head, 0};
        code = code << 6U | (byte(i) & 0x3fU);
    }
    const bool longer_than_needed = code < (bytes == 4 ? 0x10000U : bytes == 3 ? 0x800U : 0x80U);
    const bool surrogate = code >= 0xd800 && code < 0xe000;
    if (longer_than_needed || surrogate || code > 0x10ffff) return {head, 0};
    return {code, bytes};
}

bool obeyed(std::uint32_t code) {
    const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0);
    const bool separator = code == 0x2028 || code == 0x2029;
    const bool direction = code == 0x61c || code == 0x200e || code == 0x200f ||
                           (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
    return control || separator || direction;
}

}  // namespace

std::string printable(std::string_view text, bool lines) {
    std::string out;
    while (!text.empty()) {
        const Character c = first_of(text);
        if (c.bytes == 0) {
            out += fmt::format("\\x{:02x}", c.code);
            text.remove_prefix(1);
            continue;
        }
        if (!obeyed(c.code) || (lines && c.code == '\n'))
            out += text.substr(0, c.bytes);
        else
            out += c.code < 0x80 ? fmt::format("\\x{:02x}", c.code) : fmt::format("\\u{:04x}", c.code);
        text.remove_prefix(c.bytes);
    }
    return out;
}

void print(std::string_view text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
        throw NotWritten{std::string{"standard output: "} + std::strerror(errno)};
}

bool nobody_reads() noexcept {
    pollfd output{.fd = STDOUT_FILENO, .events = 0, .revents = 0};
    return ::poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

}  // namespace shaker::ctl
