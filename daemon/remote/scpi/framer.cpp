#include "daemon/remote/scpi/framer.hpp"

#include <algorithm>

namespace shaker::scpi {

std::string_view TelnetGreeting::rest(std::string_view bytes) noexcept {
    constexpr unsigned char escape = 255, will = 251, begins_list = 250, ends_list = 240;
    for (; !bytes.empty() && state_ != State::over; bytes.remove_prefix(1)) {
        const auto byte = static_cast<unsigned char>(bytes.front());
        switch (state_) {
            case State::between:
                state_ = byte == escape ? State::command : State::over;
                if (state_ == State::over) return bytes;
                break;
            case State::command:
                state_ = byte == begins_list ? State::list : byte >= will ? State::option : State::between;
                break;
            case State::list:
                if (byte == escape) state_ = State::list_end;
                break;
            case State::list_end:
                state_ = byte == ends_list ? State::between : State::list;
                break;
            case State::option:
            case State::over:
                state_ = State::between;
                break;
        }
    }
    return bytes;
}

bool Scanner::plain(char c) noexcept {
    if (c == '"' || c == '\'') {
        state_ = State::quoted;
        quote_ = c;
        return false;
    }
    if (c == '#' && value_may_begin_) {
        state_ = State::hash;
        return false;
    }
    value_may_begin_ = is_blank(c) || c == ',';
    return true;
}

bool Scanner::step(char c) noexcept {
    switch (state_) {
        case State::plain:
            return plain(c);
        case State::quoted:
            if (c != quote_ && c != '\n') return false;
            state_ = State::plain;
            value_may_begin_ = false;
            return c == '\n';
        case State::hash:
            left_ = 0;
            digits_ = static_cast<std::uint8_t>(c - '0');
            state_ = !is_digit(c) ? State::plain : c == '0' ? State::open_block : State::length;
            return is_digit(c) ? false : plain(c);
        case State::length:
            if (!is_digit(c)) {
                state_ = State::plain;
                return plain(c);
            }
            left_ = 10 * left_ + static_cast<std::uint64_t>(c - '0');
            if (--digits_ == 0) state_ = left_ > 0 ? State::block : State::plain;
            return false;
        case State::block:
            skip_block(1);
            return false;
        case State::open_block:
            if (c != '\n') return false;
            state_ = State::plain;
            return true;
    }
    return true;
}

void Scanner::skip_block(std::uint64_t bytes) noexcept {
    left_ -= bytes;
    if (left_ == 0) state_ = State::plain;
}

Text first_unit(Text message, bool value_may_begin) noexcept {
    Scanner scanner{value_may_begin};
    for (char* at = message.at; at != message.end; ++at)
        if (scanner.step(*at) && *at == ';') return {message.at, at};
    return message;
}

bool Framer::keep(std::string_view bytes) {
    if (passing_over_) return true;
    if (message_.size() + bytes.size() <= limit_) {
        message_ += bytes;
        return true;
    }
    message_.clear();
    passing_over_ = true;
    return false;
}

Framer::Event Framer::take(std::string_view& stream) {
    if (done_) message_.clear();
    done_ = false;
    while (!stream.empty()) {
        std::size_t taken = 0;
        bool ended = false;
        if (const std::uint64_t left = scanner_.block_left(); left > 0) {
            taken = static_cast<std::size_t>(std::min<std::uint64_t>(left, stream.size()));
            scanner_.skip_block(taken);
        } else {
            while (taken < stream.size() && scanner_.block_left() == 0 && !ended) {
                ended = scanner_.step(stream[taken]) && stream[taken] == '\n';
                ++taken;
            }
        }
        const bool kept = keep(stream.substr(0, ended ? taken - 1 : taken));
        stream.remove_prefix(taken);
        if (ended) {
            scanner_ = Scanner{};
            done_ = true;
            const bool whole = !passing_over_;
            passing_over_ = false;
            if (whole) return Event::message;
            message_.clear();
            done_ = false;
            if (!kept) return Event::too_long;
        } else if (!kept) {
            return Event::too_long;
        }
    }
    return Event::none;
}

}  // namespace shaker::scpi
