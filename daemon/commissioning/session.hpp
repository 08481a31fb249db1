#pragma once
// A bench on call that the commissioning drives and stops on purpose.
#include <atomic>
#include <chrono>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "daemon/remote/server.hpp"
#include "daemon/run/runner.hpp"
#include "daemon/service/bench_service.hpp"
#include "drivers/devices.hpp"

namespace shaker::commissioning {

/// Present state and first opening of a contact. Thread safety: any thread.
class ContactWatch {
public:
    using Clock = std::chrono::steady_clock;
    /// Forgets the opening.
    void restart() noexcept { opened_ = 0; }
    void note(bool open) noexcept {
        open_ = open;
        Clock::rep none = 0;
        if (open) opened_.compare_exchange_strong(none, Clock::now().time_since_epoch().count());
    }
    /// At the newest reading, or unreadable.
    [[nodiscard]] bool open() const noexcept { return open_; }
    /// First reading of an open contact since restart(). A contact may bounce.
    [[nodiscard]] Clock::time_point opened_at() const noexcept {
        return Clock::time_point{Clock::duration{opened_}};
    }

private:
    std::atomic<bool> open_{false};
    std::atomic<Clock::rep> opened_{0};
};

/// Passes on the readings of another input.
class WatchedContact final : public AbortInput {
public:
    /// watch: outlives this object.
    WatchedContact(std::unique_ptr<AbortInput> input, ContactWatch& watch)
        : input_{std::move(input)}, watch_{watch} {}
    [[nodiscard]] Contact read(std::chrono::milliseconds wait) noexcept override {
        const Contact contact = input_->read(wait);
        watch_.note(contact != Contact::closed);
        return contact;
    }

private:
    std::unique_ptr<AbortInput> input_;
    ContactWatch& watch_;
};

/// A stop of the drive as it was seen.
struct SeenStop {
    safety::Trip trip;
    double after_s = 0;  // from the order, or the open contact, to the published trip
    double ramp_s = 0;   // length of the output's ramp to zero
};

/// Thread safety: one thread. All functions throw DeviceError when the bench does not follow in time, or has
/// ended.
class Session {
public:
    /// Opens the bench of a rig file and serves it on free ports of this computer. `folder`: for the socket
    /// and the files of stopped runs. rethrow: called while this object waits; it throws to end the wait.
    /// fit: called once with the opened devices, before they are used; may be empty.
    Session(const std::string& rig, const Drive& drive, const std::filesystem::path& folder,
            std::function<void()> rethrow, const std::function<void(Rig&)>& fit = {});
    /// Stops the drive softly.
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    [[nodiscard]] bench::Bench& bench() noexcept { return runner_.bench(); }
    /// Changes the set-point, starts the drive unless it is on, and waits until the base follows. Returns the
    /// state then.
    std::shared_ptr<const service::BenchState> drive(const Drive& drive);
    /// Calls `stop` and waits for the trip.
    SeenStop stopped_by(const std::function<void()>& stop);
    /// Calls `ask` and waits for the trip by the contact of the abort input, which is timed from the reading
    /// of the open contact.
    SeenStop stopped_by_contact(const std::function<void()>& ask);
    /// Stops the drive softly and waits until the bench is idle and the DAC has played its buffer.
    void end();
    void order(const service::OrderWhat& what);
    /// Orders a clear as soon as the trip may be cleared. Returns the reason of the refusal; empty: accepted.
    std::string refused_clear();
    /// Waits until the contact is closed, and a second more. False when the trip was cleared by it.
    bool stays_tripped_when_closed();
    /// State of the contact at its newest reading.
    [[nodiscard]] bool contact_open() const noexcept { return contact_.open(); }
    /// Restores the limits and clears the trip.
    void clear();
    [[nodiscard]] const remote::Server& server() const noexcept { return *server_; }
    [[nodiscard]] const std::filesystem::path& socket() const noexcept { return socket_; }

private:
    void lead();
    std::shared_ptr<const service::BenchState> wait_for(
        const std::string& what, const std::function<bool(const service::BenchState&)>& seen);
    std::shared_ptr<const service::BenchState> wait_a_second();

    /// began: the time from which the stop is counted, asked when it was seen.
    SeenStop seen_stop(const std::function<void()>& stop,
                       const std::function<std::chrono::steady_clock::time_point()>& began);
    std::string answer_to(const service::OrderWhat& what);

    ContactWatch contact_;  // first: outlives the devices
    run::Runner runner_;
    service::BenchPort port_;
    service::BenchService service_;
    std::filesystem::path socket_;
    std::unique_ptr<remote::Server> server_;
    Drive drive_;
    std::function<void()> rethrow_;
    std::atomic<std::int64_t> ramp_{0};  // samples of the newest stop
    std::mutex mutex_;                   // guards ended_
    std::exception_ptr ended_;
    std::jthread leader_;
};

}  // namespace shaker::commissioning
