#include "daemon/remote/scpi/status/status_register.hpp"

#include <utility>

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

}  // namespace shaker::scpi
