#include "daemon/service/heartbeats.hpp"

namespace shaker::service {

Heartbeat& Heartbeats::add(const std::string& name, Heartbeat::Duration silence) {
    return all_.emplace_back(name, silence);
}

const Heartbeat* Heartbeats::overdue(std::chrono::steady_clock::time_point now) {
    const Heartbeat* first = nullptr;
    for (Heartbeat& one : all_) {
        const std::uint64_t beats = one.beats_;
        if (beats != one.seen_ || beats == one.rested_) {
            one.seen_ = beats;
            one.changed_ = now;
        } else if (now - one.changed_ > one.silence_ && first == nullptr) {
            first = &one;
        }
    }
    return first;
}

}  // namespace shaker::service
