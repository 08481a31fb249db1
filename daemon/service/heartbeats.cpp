#include "daemon/service/heartbeats.hpp"

#include <utility>

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

void BenchHeartbeats::follow(const acquisition::Channels& channels, const run::Recordings& recordings) {
    const std::int64_t gathered = channels.gathered;
    if (std::exchange(gathered_, gathered) != gathered) output_.beat();
    const bool finishing = recordings.finishing();
    const std::uint64_t progress = recordings.progress();
    const bool moved = std::exchange(progress_, progress) != progress;
    const bool began = !std::exchange(finishing_, finishing);
    if (!finishing)
        recorder_.rest();
    else if (moved || began)
        recorder_.beat();
}

}  // namespace shaker::service
