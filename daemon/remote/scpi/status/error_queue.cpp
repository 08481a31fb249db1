#include "daemon/remote/scpi/status/error_queue.hpp"

#include <utility>

#include "daemon/remote/scpi/data/text.hpp"

namespace shaker::scpi {

Code ErrorQueue::push(Code code, std::string_view detail) {
    if (entries_.size() == capacity) {
        entries_.back() = {Code::queue_overflow, std::string{standard_message(Code::queue_overflow)}};
        return Code::queue_overflow;
    }
    std::string text{standard_message(code)};
    if (!detail.empty()) text.append(";").append(detail);
    entries_.push_back({code, printable(text, longest_text)});
    return code;
}

ErrorQueue::Entry ErrorQueue::pop() {
    if (entries_.empty()) return {Code::none, std::string{standard_message(Code::none)}};
    Entry first = std::move(entries_.front());
    entries_.pop_front();
    return first;
}

}  // namespace shaker::scpi
