#pragma once
// Where program messages end in a stream of bytes, and where the units in a message do.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {

/// Follows strings and blocks, in which separators are data. A # begins a block only where a value may begin,
/// behind a blank or a comma. A string ends with its line at the latest, closed or not.
class Scanner {
public:
    explicit Scanner(bool value_may_begin = false) noexcept : value_may_begin_{value_may_begin} {}
    /// Whether `c` stands outside of strings and blocks.
    bool step(char c) noexcept;
    /// Bytes of a block that must come before anything else can happen.
    [[nodiscard]] std::uint64_t block_left() const noexcept { return state_ == State::block ? left_ : 0; }
    void skip_block(std::uint64_t bytes) noexcept;

private:
    enum class State : std::uint8_t { plain, quoted, hash, length, block, open_block };
    bool plain(char c) noexcept;

    State state_ = State::plain;
    char quote_ = 0;
    bool value_may_begin_;
    std::uint8_t digits_ = 0;
    std::uint64_t left_ = 0;  // of the block's length as far as it was read; then of its data
};

/// The rest of a unit, up to its semicolon or the end of the message; `value_may_begin`: a blank or a comma
/// is before.
Text first_unit(Text message, bool value_may_begin) noexcept;

/// Cuts messages out of a stream, bounded: one that is longer than `limit` bytes is passed over to its end.
class Framer {
public:
    enum class Event { none, message, too_long };

    explicit Framer(std::size_t limit) : limit_{limit} {}

    /// Takes bytes off `stream` until a message is complete (its text is then message()), until one has grown
    /// too long, which is told once, or until none are left.
    Event take(std::string_view& stream);
    /// Without its line feed. Valid, and the caller's to change, until the next take().
    [[nodiscard]] Text message() noexcept { return {message_.data(), message_.data() + message_.size()}; }
    /// What has come of a message that is not complete yet.
    [[nodiscard]] std::string_view begun() const noexcept { return done_ ? std::string_view{} : message_; }

private:
    bool keep(std::string_view bytes);

    std::size_t limit_;
    std::string message_;
    Scanner scanner_;
    bool done_ = true;
    bool passing_over_ = false;
};

}  // namespace shaker::scpi
