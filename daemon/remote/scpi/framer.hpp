#pragma once
// Scanner and Framer: find the ends of messages in a stream of bytes, and of units in a message.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {

/// What a telnet client sends before its first command (RFC 854): requests for options, which are not
/// answered.
class TelnetGreeting {
public:
    /// The bytes behind the greeting; none while it may go on.
    std::string_view rest(std::string_view bytes) noexcept;

private:
    enum class State : std::uint8_t { between, command, option, list, list_end, over };
    State state_ = State::between;
};

/// Recognises strings and blocks, in which separators are data. A # starts a block only after a blank or
/// comma. A string ends with its line at the latest, closed or not.
class Scanner {
public:
    explicit Scanner(bool value_may_begin = false) noexcept : value_may_begin_{value_may_begin} {}
    /// Advances by `c`; true if `c` is outside strings and blocks.
    bool step(char c) noexcept;
    /// Bytes of the present block that are still to come.
    [[nodiscard]] std::uint64_t block_left() const noexcept { return state_ == State::block ? left_ : 0; }
    void skip_block(std::uint64_t bytes) noexcept;

private:
    enum class State : std::uint8_t { plain, quoted, hash, length, block, open_block };
    bool plain(char c) noexcept;

    State state_ = State::plain;
    char quote_ = 0;
    bool value_may_begin_;
    std::uint8_t digits_ = 0;
    std::uint64_t left_ = 0;  // while reading the block's length: its value so far; then bytes of data left
};

/// The rest of a unit, up to its semicolon or the end of the message. value_may_begin: a blank or comma
/// precedes.
Text first_unit(Text message, bool value_may_begin) noexcept;

/// Extracts messages from a stream. A message longer than `limit` bytes is skipped to its end.
class Framer {
public:
    enum class Event { none, message, too_long };

    explicit Framer(std::size_t limit) : limit_{limit} {}

    /// Takes bytes from `stream` until a message is complete (see message()), until one has become too long
    /// (reported once), or until none are left.
    Event take(std::string_view& stream);
    /// The message without its line feed. Valid and modifiable until the next take().
    [[nodiscard]] Text message() noexcept { return {message_.data(), message_.data() + message_.size()}; }
    /// The part of an incomplete message received so far.
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
