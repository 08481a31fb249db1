#include "daemon/acquisition/executors.hpp"

#include <atomic>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>

#include "drivers/realtime.hpp"

namespace shaker::acquisition {

namespace {

class Stopwatch {
public:
    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>{std::chrono::steady_clock::now() - began_}.count();
    }

private:
    std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

// Requests name, stack and priority of a loop's thread; returns the refusals.
std::vector<std::string> prepare_thread(const Loop& loop) {
    constexpr std::size_t stack = 262144;  // bytes
    std::vector<std::string> refused;
    refused.reserve(3);
    refused.push_back(name_thread(loop.name));
    if (loop.fifo_priority > 0) {
        refused.push_back(prefault_stack(stack));
        refused.push_back(use_fifo_priority(loop.fifo_priority));
    }
    std::erase(refused, "");
    for (std::string& why : refused) why.insert(0, loop.name + ": ");
    return refused;
}

}  // namespace

void Pacer::wait_until(double s) {
    using Clock = std::chrono::steady_clock;
    const auto steps = [](double seconds) {
        return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>{seconds});
    };
    const auto since = steps(s);
    const auto now = Clock::now();
    if (!begin_) begin_ = now - since;
    if (now - (*begin_ + since) > steps(made_up_s)) begin_ = now - since;
    std::this_thread::sleep_until(*begin_ + since);
}

Execution run_lockstep(std::vector<Loop>& loops, const std::function<bool()>& done) {
    const Stopwatch watch;
    constexpr std::chrono::milliseconds no_wait{0};
    while (!done()) {
        loops.front().step(no_wait);
        for (std::size_t i = 1; i < loops.size(); ++i)
            while (loops[i].step(no_wait)) {
            }
    }
    return {watch.seconds(), {}};
}

Execution run_threaded(std::vector<Loop>& loops, const std::function<bool()>& done,
                       const std::function<void()>& unblock) {
    const Stopwatch watch;
    constexpr std::chrono::milliseconds wait{50}, pause{1};
    std::mutex mutex;
    std::vector<std::string> refused;
    if (std::string why = lock_memory(); !why.empty()) refused.push_back(std::move(why));
    std::exception_ptr error;
    std::stop_source stop;
    {
        std::vector<std::jthread> threads;
        for (std::size_t i = 0; i < loops.size(); ++i) {
            threads.emplace_back([&, i] {
                Loop& loop = loops[i];
                for (std::string& why : prepare_thread(loop)) {
                    const std::scoped_lock lock{mutex};
                    refused.push_back(std::move(why));
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
    return {watch.seconds(), std::move(refused)};
}

}  // namespace shaker::acquisition
