#pragma once
// ErrorQueue: errors of one session, oldest first, until read by the client.
#include <cstddef>
#include <deque>
#include <string>
#include <string_view>

#include "daemon/remote/scpi/data/error.hpp"

namespace shaker::scpi {

/// Bounded: when full, its newest entry becomes -350 and later errors are lost.
class ErrorQueue {
public:
    static constexpr std::size_t capacity = 32;
    static constexpr std::size_t longest_text = 255;  // characters, as in SCPI-99

    struct Entry {
        Code code = Code::none;
        std::string text;  // the standard's text, then ";" and the detail if there is one
    };

    /// Returns the code stored: -350 when the queue was full.
    Code push(Code code, std::string_view detail);
    /// Code::none, "No error" when empty.
    Entry pop();
    void clear() noexcept { entries_.clear(); }
    [[nodiscard]] bool empty() const noexcept { return entries_.empty(); }
    [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }

private:
    std::deque<Entry> entries_;
};

}  // namespace shaker::scpi
