#include "daemon/executors.hpp"

#include <atomic>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>

#include "drivers/realtime.hpp"

namespace shaker {

void run_lockstep(std::vector<Loop>& loops, const std::function<bool()>& done) {
    constexpr std::chrono::milliseconds no_wait{0};
    while (!done()) {
        loops.front().step(no_wait);
        for (std::size_t i = 1; i < loops.size(); ++i)
            while (loops[i].step(no_wait)) {
            }
    }
}

std::vector<std::string> run_threaded(std::vector<Loop>& loops, const std::function<bool()>& done,
                                      const std::function<void()>& unblock) {
    constexpr std::chrono::milliseconds wait{50}, pause{1};
    std::mutex mutex;
    std::vector<std::string> refused;
    std::exception_ptr error;
    std::stop_source stop;
    {
        std::vector<std::jthread> threads;
        for (std::size_t i = 0; i < loops.size(); ++i) {
            threads.emplace_back([&, i] {
                Loop& loop = loops[i];
                const std::string unnamed = name_thread(loop.name);
                const std::string unranked =
                    loop.fifo_priority > 0 ? use_fifo_priority(loop.fifo_priority) : "";
                for (const std::string& why : {unnamed, unranked}) {
                    const std::scoped_lock lock{mutex};
                    if (!why.empty()) refused.push_back(loop.name + ": " + why);
                }
                try {
                    while (!stop.stop_requested()) {
                        if (!loop.step(wait) && !loop.waits) std::this_thread::sleep_for(pause);
                        if (i + 1 == loops.size() && done()) stop.request_stop();
                    }
                } catch (...) {
                    const std::scoped_lock lock{mutex};
                    if (!error) error = std::current_exception();
                    stop.request_stop();
                }
                unblock();
            });
        }
    }
    if (error) std::rethrow_exception(error);
    return refused;
}

}  // namespace shaker
