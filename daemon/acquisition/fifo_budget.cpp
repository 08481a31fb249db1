#include "daemon/acquisition/fifo_budget.hpp"

#include "drivers/realtime.hpp"

namespace shaker::acquisition {

namespace {
constexpr std::chrono::milliseconds window{100};
constexpr double window_s = std::chrono::duration<double>{window}.count();
}  // namespace

FifoBudget::FifoBudget(int priority, double share) noexcept
    : priority_{share < 1 ? priority : 0}, share_{share} {}

void FifoBudget::spend() noexcept {
    if (priority_ == 0) return;
    const auto now = std::chrono::steady_clock::now();
    const double used_s = thread_time_s();
    if (now - since_ >= window) {
        since_ = now;
        used_s_ = used_s;
        if (spent_ && use_fifo_priority(priority_).empty()) spent_ = false;
    } else if (!spent_ && used_s - used_s_ > share_ * window_s) {
        use_ordinary_priority();
        spent_ = true;
    }
}

}  // namespace shaker::acquisition
