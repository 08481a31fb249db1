#include "drivers/beside.hpp"

#include <spdlog/fmt/fmt.h>

#include <system_error>

#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"

namespace shaker {

void Beside::grant() {
    if (!threaded_ || thread_.joinable()) return;
    try {
        thread_ = std::jthread{[this](const std::stop_token& stop) { serve(stop); }};
    } catch (const std::system_error& e) {
        throw DeviceError{fmt::format(
            "the system grants no thread ({}): raise TasksMax= of the service, or \"ulimit -u\"", e.what())};
    }
}

void Beside::give(std::function<void(const std::stop_token&)> work) {
    if (!threaded_) return work({});
    grant();
    {
        const std::scoped_lock lock{mutex_};
        waiting_.push_back(std::move(work));
    }
    changed_.notify_one();
}

void Beside::serve(const std::stop_token& stop) {
    if (!name_.empty()) {
        static_cast<void>(name_thread(name_));
        use_ordinary_priority();  // the thread that asked for it may have another
    }
    for (;;) {
        std::function<void(const std::stop_token&)> work;
        {
            std::unique_lock lock{mutex_};
            if (!changed_.wait(lock, stop, [&] { return !waiting_.empty(); }) || stop.stop_requested())
                return;
            work = std::move(waiting_.front());
            waiting_.pop_front();
        }
        work(stop);
    }
}

}  // namespace shaker
