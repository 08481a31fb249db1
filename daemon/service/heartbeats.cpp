#include "daemon/service/heartbeats.hpp"

#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>

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

SystemdNotify::SystemdNotify() {
    std::uint64_t us = 0;
    if (sd_watchdog_enabled(0, &us) > 0) every_ = std::chrono::microseconds{us / 8};
}

void SystemdNotify::report(const BenchState& state, Heartbeats& heartbeats, bool leaving) {
    if (leaving && !std::exchange(stopping_, true)) sd_notify(0, "STOPPING=1");
    if (!ready_ && row_of(state.state).ready) {
        ready_ = true;
        sd_notify(0, "READY=1");
    }
    std::string status = state.trip ? text(*state.trip) : std::string{name(state.state)};
    if (state.state == run::RunState::finishing)
        status += " " + state.recording.name;
    else if (state.recording.finishing)
        status += ", finishing " + state.recording.name;
    if (status != status_) {
        status_ = std::move(status);
        sd_notify(0, ("STATUS=" + status_).c_str());
    }
    const auto now = std::chrono::steady_clock::now();
    const Heartbeat* late = heartbeats.overdue(now);
    if (late != std::exchange(late_, late) && late != nullptr && every_.count() > 0)
        spdlog::error("the {} gives no sign of life; the watchdog is not fed", late->name());
    if (late != nullptr) return;
    feed_watchdog(now);
    if (!stopping_ || now - extended_ < stop_patience / 10) return;
    extended_ = now;
    sd_notify(
        0,
        ("EXTEND_TIMEOUT_USEC=" + std::to_string(std::chrono::microseconds{stop_patience}.count())).c_str());
}

void SystemdNotify::feed_watchdog(std::chrono::steady_clock::time_point now) {
    if (every_.count() == 0 || now - signalled_ < every_) return;
    signalled_ = now;
    sd_notify(0, "WATCHDOG=1");
}

}  // namespace shaker::service
