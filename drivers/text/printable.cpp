#include "drivers/text/printable.hpp"

#include <cstdint>

namespace shaker {

namespace {

struct Character {
    std::uint32_t code;
    std::size_t bytes;  // 0: invalid UTF-8
};

// Bytes of a character that begins with this one; 0: none does.
std::size_t bytes_after(unsigned head) noexcept {
    if (head < 0x80) return 1;
    if (head < 0xc2 || head >= 0xf5) return 0;
    return head >= 0xf0 ? 4 : head >= 0xe0 ? 3 : 2;
}

Character first_of(std::string_view text) noexcept {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned head = byte(0);
    const std::size_t bytes = bytes_after(head);
    if (bytes < 2) return {head, bytes};
    if (text.size() < bytes) return {head, 0};
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

bool obeyed(std::uint32_t code) noexcept {
    const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0);
    const bool separator = code == 0x2028 || code == 0x2029;
    const bool direction = code == 0x61c || code == 0x200e || code == 0x200f ||
                           (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
    return control || separator || direction;
}

void append_hex(std::string& out, std::uint32_t code, unsigned digits) {
    for (unsigned i = digits; i-- > 0;) out += "0123456789abcdef"[code >> 4 * i & 0xfU];
}

}  // namespace

std::string printable(std::string_view text, bool lines) {
    std::string out;
    out.reserve(text.size());
    while (!text.empty()) {
        const Character c = first_of(text);
        const bool kept = c.bytes > 0 && (!obeyed(c.code) || (lines && (c.code == '\n' || c.code == '\t')));
        if (kept) {
            out += text.substr(0, c.bytes);
        } else if (c.bytes == 0 || c.code < 0x20) {
            out += "\\x";
            append_hex(out, c.code, 2);
        } else {
            out += "\\u";
            append_hex(out, c.code, 4);
        }
        text.remove_prefix(c.bytes == 0 ? 1 : c.bytes);
    }
    return out;
}

std::size_t unfinished_bytes(std::string_view text) noexcept {
    for (std::size_t n = 1; n <= 3 && n <= text.size(); ++n) {
        const auto byte = static_cast<unsigned char>(text[text.size() - n]);
        if ((byte & 0xc0U) != 0x80) return bytes_after(byte) > n ? n : 0;
    }
    return 0;
}

}  // namespace shaker
