#pragma once
// Bytes that a terminal obeys.
#include <string>
#include <string_view>

namespace shaker::test {

/// Changes the terminal in every way that text can: C0, C1 as UTF-8 and as bytes, DEL, writing direction.
inline const std::string hostile_text =
    "\x1b[2J\x9b"
    "31m\xc2\x9b"
    "32m\x07\r\x7f\xff\xe2\x80\xae";

/// Controls in what a program printed, in hex, except line ends and tabs.
inline std::string controls_in(std::string_view printed) {
    constexpr std::string_view hex = "0123456789abcdef";
    std::string found;
    bool continued = false;  // UTF-8: the byte belongs to the character before
    unsigned lead = 0;
    for (const char c : printed) {
        const auto byte = static_cast<unsigned char>(c);
        const bool c0 = (byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7f;
        const bool c1 = byte >= 0x80 && byte < 0xa0 && (!continued || lead == 0xc2);
        if (c0 || c1) found += {hex[byte >> 4U], hex[byte & 15U], ' '};
        if (byte >= 0xc0) lead = byte;
        continued = byte >= 0x80;
    }
    return found;
}

}  // namespace shaker::test
