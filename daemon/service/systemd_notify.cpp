#include "daemon/service/systemd_notify.hpp"

#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>

#include <utility>

namespace shaker::service {

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
