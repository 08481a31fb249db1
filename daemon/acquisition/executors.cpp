#include "daemon/acquisition/executors.hpp"

#include <exception>
#include <latch>
#include <mutex>
#include <stop_token>
#include <system_error>
#include <thread>

#include "drivers/lent_priority.hpp"
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

// Requests stack and priority for a loop's thread, the calling one.
RealTimeGrant prepare_thread(const Loop& loop, std::optional<LentPriority>& priority) {
    constexpr std::size_t stack = 262144;  // bytes
    const std::string no_stack = prefault_stack(stack);
    priority.emplace(pthread_self(), loop.fifo_priority, loop.fifo_share);
    std::string refused;
    for (const std::string& why : {no_stack, priority->refused()})
        if (!why.empty()) refused += (refused.empty() ? loop.name + ": " : "; ") + why;
    return {loop.name, refused};
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

double run_lockstep(std::vector<Loop>& loops, const std::function<bool()>& done, const RunHooks& hooks) {
    const Stopwatch watch;
    constexpr std::chrono::milliseconds no_wait{0};
    hooks.begun({});
    std::size_t at = 0;
    const auto round = [&](std::size_t failed) {
        for (at = 0; at < loops.size(); ++at)
            while (at != failed && loops[at].step(no_wait) && at > 0) {
            }
    };
    try {
        while (!done()) round(loops.size());
    } catch (...) {
        const std::size_t failed = std::min(at, loops.size() - 1);
        constexpr int most_rounds = 2000;
        for (int i = 0; i < most_rounds && !hooks.wound_down(failed); ++i) round(failed);
        throw;
    }
    return watch.seconds();
}

namespace {

/// Threads of one run. The first failure is kept.
class Threads {
public:
    Threads(std::vector<Loop>& loops, const std::function<bool()>& done, const RunHooks& hooks)
        : loops_{loops}, done_{done}, hooks_{hooks}, ready_{std::ssize(loops)} {}

    void run(std::size_t i) noexcept try {
        Loop& loop = loops_[i];
        static_cast<void>(name_thread(loop.name));
        std::optional<LentPriority> priority;
        if (loop.fifo_priority > 0) add(prepare_thread(loop, priority));
        ready_.arrive_and_wait();
        if (stop_.stop_requested()) return;
        if (last(i)) hooks_.begun(grants_);
        while (!stop_.stop_requested()) {
            if (!loop.step(wait) && !loop.waits) std::this_thread::sleep_for(loop.pause);
            if (last(i) && done_()) stop_.request_stop();
        }
    } catch (...) {
        fail(i, std::current_exception());
    }
    void add(RealTimeGrant grant) {
        const std::scoped_lock lock{mutex_};
        grants_.push_back(std::move(grant));
    }
    /// Threads from number `begun` on could not be created.
    void give_up(std::size_t begun) noexcept {
        stop_.request_stop();
        ready_.count_down(std::ssize(loops_) - static_cast<std::ptrdiff_t>(begun));
    }
    [[nodiscard]] std::exception_ptr error() const { return error_; }

private:
    static constexpr std::chrono::milliseconds wait{50}, pause{1};
    [[nodiscard]] bool last(std::size_t i) const noexcept { return i + 1 == loops_.size(); }

    void fail(std::size_t i, std::exception_ptr why) noexcept {
        {
            const std::scoped_lock lock{mutex_};
            if (!error_) error_ = std::move(why);
        }
        const Stopwatch watch;
        while (!stop_.stop_requested() && !hooks_.wound_down(i) && watch.seconds() < longest_wind_down_s)
            std::this_thread::sleep_for(pause);
        stop_.request_stop();
    }

    std::vector<Loop>& loops_;
    const std::function<bool()>& done_;
    const RunHooks& hooks_;
    std::latch ready_;
    std::stop_source stop_;
    std::mutex mutex_;
    std::vector<RealTimeGrant> grants_;
    std::exception_ptr error_;
};

}  // namespace

double run_threaded(std::vector<Loop>& loops, const std::function<bool()>& done,
                    const std::function<void()>& unblock, const RunHooks& hooks) {
    const Stopwatch watch;
    Threads run{loops, done, hooks};
    const bool real_time = std::ranges::any_of(loops, [](const Loop& l) { return l.fifo_priority > 0; });
    if (real_time) run.add({"memory", lock_memory()});
    {
        std::vector<std::jthread> threads;
        threads.reserve(loops.size());
        try {
            for (std::size_t i = 0; i < loops.size(); ++i)
                threads.emplace_back([&, i] {
                    run.run(i);
                    unblock();
                });
        } catch (const std::system_error&) {
            run.give_up(threads.size());
            throw;
        }
    }
    if (run.error()) std::rethrow_exception(run.error());
    return watch.seconds();
}

}  // namespace shaker::acquisition
