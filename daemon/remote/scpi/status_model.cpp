#include "daemon/remote/scpi/status_model.hpp"

#include <utility>

#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {

StatusRegister::StatusRegister(const ConditionRegister& condition)
    : condition_{&condition},
      changes_seen_{condition.changes()},
      rises_seen_{condition.rises()},
      falls_seen_{condition.falls()} {}

void StatusRegister::update() noexcept {
    if (changes_seen_ == condition_->changes()) return;
    for (std::size_t bit = 0; bit < rises_seen_.size(); ++bit) {
        const bool rose = rises_seen_[bit] != condition_->rises()[bit];
        const bool fell = falls_seen_[bit] != condition_->falls()[bit];
        const unsigned mask = 1U << bit;
        if ((rose && (rising_ & mask) != 0) || (fell && (falling_ & mask) != 0))
            event_ = static_cast<std::uint16_t>(event_ | mask);
    }
    changes_seen_ = condition_->changes();
    rises_seen_ = condition_->rises();
    falls_seen_ = condition_->falls();
}

std::uint16_t StatusRegister::take_event() noexcept {
    update();
    return std::exchange(event_, std::uint16_t{0});
}

bool StatusRegister::summary() noexcept {
    update();
    return (event_ & enabled_) != 0;
}

void StatusRegister::preset() noexcept {
    update();
    enabled_ = 0;
    rising_ = usable;
    falling_ = 0;
}

void StatusRegister::filter_rising(std::uint16_t mask) noexcept {
    update();
    rising_ = mask & usable;
}

void StatusRegister::filter_falling(std::uint16_t mask) noexcept {
    update();
    falling_ = mask & usable;
}

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

void StatusModel::report(Code code, std::string_view detail) {
    ++reported_;
    const Code queued = errors.push(code, detail);
    raise_event(static_cast<std::uint8_t>(event_bit(code) | event_bit(queued)));
}

std::uint8_t StatusModel::take_events() noexcept { return std::exchange(events_, std::uint8_t{0}); }

void StatusModel::clear() noexcept {
    events_ = 0;
    errors.clear();
    operation.clear_event();
    questionable.clear_event();
}

std::uint8_t StatusModel::status_byte(bool message_available) noexcept {
    unsigned bits = 0;
    if (!errors.empty()) bits |= stb::errors;
    if (questionable.summary()) bits |= stb::questionable;
    if (message_available) bits |= stb::message_available;
    if ((events_ & event_mask_) != 0) bits |= stb::event_status;
    if (operation.summary()) bits |= stb::operation;
    if ((bits & service_mask_) != 0) bits |= stb::master_summary;
    return static_cast<std::uint8_t>(bits);
}

}  // namespace shaker::scpi
