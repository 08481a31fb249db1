#pragma once
// Signs of life of the daemon's threads, and the messages to the service manager: ready, a line with the
// state, and watchdog signals while all threads are alive.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <string>

#include "daemon/acquisition/channels.hpp"
#include "daemon/run/recordings.hpp"
#include "daemon/service/bench_state.hpp"

namespace shaker::service {

/// Sign of life of one thread.
/// Thread safety: any thread calls beat() and rest(); they never wait.
class Heartbeat {
public:
    using Duration = std::chrono::steady_clock::duration;
    /// silence: longest time between two beats of a live thread.
    Heartbeat(std::string name, Duration silence) : name_{std::move(name)}, silence_{silence} {}
    void beat() noexcept { ++beats_; }
    /// No beat is expected until the next one: the thread has nothing to do.
    void rest() noexcept { rested_ = beats_.load(); }

    [[nodiscard]] const std::string& name() const noexcept { return name_; }

private:
    friend class Heartbeats;
    std::string name_;
    Duration silence_;
    std::atomic<std::uint64_t> beats_{0};
    std::atomic<std::uint64_t> rested_{0};  // value of beats_ at rest(); before the first beat it is at rest
    std::uint64_t seen_ = 0;
    std::chrono::steady_clock::time_point changed_{};
};

/// All heartbeats. One thread, except the heartbeats themselves.
class Heartbeats {
public:
    /// Adds a thread. Nothing is expected of it before its first beat. The reference stays valid.
    Heartbeat& add(const std::string& name, Heartbeat::Duration silence);
    /// A heartbeat that is overdue; null while all threads are alive or at rest. Call it often.
    [[nodiscard]] const Heartbeat* overdue(std::chrono::steady_clock::time_point now);

private:
    std::deque<Heartbeat> all_;
};

/// The heartbeats of a bench on call. Output: played blocks that the reduction thread has gathered. Recorder:
/// progress of the completion of a recording, which may take minutes; at rest otherwise. Other threads add
/// their own (all()).
class BenchHeartbeats {
public:
    /// Call it after each step of the service.
    void follow(const acquisition::Channels& channels, const run::Recordings& recordings);
    [[nodiscard]] Heartbeats& all() noexcept { return all_; }

private:
    Heartbeats all_;
    Heartbeat& output_ = all_.add("output", std::chrono::milliseconds{300});
    Heartbeat& recorder_ = all_.add("recorder", std::chrono::seconds{60});
    std::int64_t gathered_ = 0;
    std::uint64_t progress_ = 0;
    bool finishing_ = false;
};

/// Does nothing without a service manager.
class SystemdNotify {
public:
    SystemdNotify();
    /// Longest time that the manager waits for the end of the daemon after the newest report of a live one.
    static constexpr std::chrono::seconds stop_patience{10};

    /// Call it often. While a heartbeat is overdue, no watchdog signal is sent, and the manager ends the
    /// program. leaving: the daemon is shutting down: it ramps the drive to zero and completes recordings.
    /// The manager then waits stop_patience longer, again and again, while no heartbeat is overdue.
    void report(const BenchState& state, Heartbeats& heartbeats, bool leaving);

private:
    void feed_watchdog(std::chrono::steady_clock::time_point now);

    std::chrono::steady_clock::duration every_{};  // between two watchdog signals; 0: no watchdog
    std::chrono::steady_clock::time_point signalled_{};
    std::chrono::steady_clock::time_point extended_{};
    const Heartbeat* late_ = nullptr;
    bool ready_ = false, stopping_ = false;
    std::string status_;
};

}  // namespace shaker::service
