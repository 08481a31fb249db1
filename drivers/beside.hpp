#pragma once
// Beside: one thread for work that must not hold up its caller.
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

namespace shaker {

/// Does work in its order, in a thread that it keeps. std::async asks the system for a thread each time, and
/// a system that grants none then ends what asked, in the middle of a drive. Thread safety: one thread calls.
class Beside {
public:
    /// name: of the thread, at most 15 characters, whose priority is ordinary; empty: it keeps name and
    /// priority of the thread that asks for it, as a confined program must. threaded: false in lockstep;
    /// run() then does the work.
    Beside(std::string name, bool threaded) : name_{std::move(name)}, threaded_{threaded} {}
    /// Work under way is asked to stop and waited for; what waits is dropped.
    ~Beside() = default;
    Beside(const Beside&) = delete;
    Beside& operator=(const Beside&) = delete;

    /// Asks for the thread now, and not with the first work. DeviceError, with the remedy, when the system
    /// grants none.
    void grant();
    /// The coming result of work(), or of work(std::stop_token), or its exception. DeviceError as grant();
    /// then nothing was begun.
    template <class Work>
    auto run(Work work) {
        constexpr bool stoppable = std::is_invocable_v<Work&, std::stop_token>;
        auto whole = [work = std::move(work)](const std::stop_token& stop) mutable {
            static_cast<void>(stop);
            if constexpr (stoppable)
                return work(stop);
            else
                return work();
        };
        using Result = std::invoke_result_t<decltype(whole)&, std::stop_token>;
        auto task = std::make_shared<std::packaged_task<Result(std::stop_token)>>(std::move(whole));
        auto result = task->get_future();
        give([task](const std::stop_token& stop) { (*task)(stop); });
        return result;
    }

private:
    void give(std::function<void(const std::stop_token&)> work);
    void serve(const std::stop_token& stop);

    std::string name_;
    bool threaded_;
    std::mutex mutex_;  // guards waiting_
    std::condition_variable_any changed_;
    std::deque<std::function<void(const std::stop_token&)>> waiting_;
    std::jthread thread_;  // the last member: it ends first
};

/// The result is there, or the exception.
template <class T>
bool is_ready(const std::future<T>& result) {
    return result.valid() && result.wait_for(std::chrono::seconds{0}) == std::future_status::ready;
}

}  // namespace shaker
