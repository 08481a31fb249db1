#include "daemon/remote/scpi/status/status_model.hpp"

#include <utility>

namespace shaker::scpi {

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
