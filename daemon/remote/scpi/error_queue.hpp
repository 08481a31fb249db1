#pragma once
// What went wrong, oldest first, until a client asks.
#include <cstddef>
#include <deque>
#include <string>
#include <string_view>

#include "daemon/remote/scpi/error.hpp"

namespace shaker::scpi {

/// Bounded: when it is full its newest entry becomes -350, and what comes after that is lost.
class ErrorQueue {
public:
    static constexpr std::size_t capacity = 32;
    static constexpr std::size_t longest_text = 255;  // characters, as SCPI-99 has it

    struct Entry {
        Code code = Code::none;
        std::string text;  // the standard message, then ";" and the detail where there is one
    };

    /// Returns what it became: -350 when the queue was full.
    Code push(Code code, std::string_view detail);
    /// Code::none, "No error" when nothing is left.
    Entry pop();
    void clear() noexcept { entries_.clear(); }
    [[nodiscard]] bool empty() const noexcept { return entries_.empty(); }
    [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }

private:
    std::deque<Entry> entries_;
};

}  // namespace shaker::scpi
