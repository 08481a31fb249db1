#include "daemon/remote/scpi/text.hpp"

#include <algorithm>

namespace shaker::scpi {

void Text::skip_blanks() noexcept {
    while (at != end && is_blank(*at)) ++at;
}

Mnemonic mnemonic(std::string_view text) noexcept {
    Mnemonic word;
    for (std::size_t i = 0; i < std::min(text.size(), longest_mnemonic); ++i) word.put(i, text[i]);
    return word;
}

Keyword::Keyword(std::string_view written) : full{mnemonic(written)} {
    for (const char c : written)
        if (c == upper(c)) short_form += c;
    brief = mnemonic(short_form);
}

std::string printable(std::string_view raw, std::size_t limit) {
    constexpr std::string_view hex = "0123456789abcdef", more = "...";
    std::string out;
    std::size_t whole = 0;  // of `out` with room for `more`
    for (const char c : raw) {
        if (c >= ' ' && c <= '~') {
            out += c;
        } else {
            const auto byte = static_cast<unsigned char>(c);
            out += {'\\', 'x', hex[byte >> 4U], hex[byte & 15U]};
        }
        if (out.size() > limit) return out.substr(0, whole) + std::string{more};
        if (out.size() + more.size() <= limit) whole = out.size();
    }
    return out;
}

bool same(std::string_view text, std::string_view capitals) noexcept {
    return std::ranges::equal(text, capitals, [](char a, char b) { return upper(a) == b; });
}

}  // namespace shaker::scpi
