#pragma once
// Text of messages: bytes, mnemonics, and printable copies of received bytes.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace shaker::scpi {

/// The rest of a message. The bytes are in the session's buffer; doubled quotes of strings are undone in
/// place.
struct Text {
    char* at = nullptr;
    char* end = nullptr;

    [[nodiscard]] bool empty() const noexcept { return at == end; }
    [[nodiscard]] std::size_t size() const noexcept { return static_cast<std::size_t>(end - at); }
    /// The next byte; NUL, which counts as a blank, at the end.
    [[nodiscard]] char peek() const noexcept { return at == end ? '\0' : *at; }
    void skip_blanks() noexcept;
};

/// IEEE 488.2 white space: the blank and all control characters, CR among them.
constexpr bool is_blank(char c) noexcept { return static_cast<unsigned char>(c) <= ' '; }
constexpr bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }
constexpr char upper(char c) noexcept { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }
constexpr bool is_letter(char c) noexcept { return upper(c) >= 'A' && upper(c) <= 'Z'; }
constexpr bool is_word(char c) noexcept { return is_letter(c) || is_digit(c) || c == '_'; }

/// The same without regard to small and capital letters. capitals: in capitals.
bool same(std::string_view text, std::string_view capitals) noexcept;

inline constexpr std::size_t longest_mnemonic = 12;

/// Up to 12 characters in upper case, compared as integers.
struct Mnemonic {
    std::uint64_t head = 0;
    std::uint32_t tail = 0;

    bool operator==(const Mnemonic&) const noexcept = default;
    /// Sets character i, below 12.
    void put(std::size_t i, char c) noexcept {
        const std::uint64_t bits = static_cast<unsigned char>(upper(c));
        if (i < 8)
            head |= bits << (8 * i);
        else
            tail |= static_cast<std::uint32_t>(bits << (8 * (i - 8)));
    }
};
/// The mnemonic of the first 12 characters of `text`.
Mnemonic mnemonic(std::string_view text) noexcept;

/// A mnemonic in the notation of manuals, "FREQuency": the capitals are the short form; both forms are
/// accepted.
struct Keyword {
    explicit Keyword(std::string_view written);
    [[nodiscard]] bool is(const Mnemonic& word) const noexcept { return word == brief || word == full; }

    std::string short_form;  // "FREQ"
    Mnemonic brief;
    Mnemonic full;
};

/// At most `limit` bytes of `raw` as printable ASCII: other bytes become \xNN, and "..." replaces the rest.
std::string printable(std::string_view raw, std::size_t limit = 40);

}  // namespace shaker::scpi
