#pragma once
// WayBack: one return of the walker, "go to x", and what the returns so far have shown.
#include <algorithm>
#include <array>
#include <cstddef>

namespace shaker::on_call {

/// A return ends with the order of the next drive. The walker goes on for some periods until that drive is in
/// force; how many is learned from every return. Lengths in m. Thread safety: one thread.
class WayBack {
public:
    /// The walker has to have `target` of way ahead of it, on side `ahead` (0: -x, 1: +x); it has `way` now.
    /// step: its walk in a period of the return. period_s: of the drive.
    void begin(double now_s, double x_m, std::size_t ahead, double way, double target, double step,
               double period_s) noexcept {
        constexpr double patience = 3,
                         patience_s = 15;  // by the expected time; in addition, for the start from rest
        x_m_ = x_m, way_ = way, target_ = target, step_ = step;
        ahead_ = ahead;
        left_ = false;
        from_s_ = now_s;
        until_s_ = now_s + patience * std::max(0.0, target - way) / step * period_s + patience_s;
    }
    /// The next drive may be ordered. ways: what is left on both sides.
    [[nodiscard]] bool arrives(const std::array<double, 2>& ways) const noexcept {
        constexpr double kept_periods = 1;  // of way on the other side
        return ways.at(ahead_) + goes_on_ * step_ >= target_ ||
               ways.at(1 - ahead_) <= std::max(goes_on_, kept_periods) * step_;
    }
    [[nodiscard]] bool late(double now_s) const noexcept { return now_s > until_s_; }
    /// The next drive is ordered; `way` is ahead of the walker.
    void leave(double now_s, double way) noexcept {
        for_s_ = now_s - from_s_;
        left_at_ = farthest_ = way;
        left_ = true;
    }
    /// Nothing is learned from this return.
    void abandon() noexcept { left_ = false; }
    /// The walker on its way after leave(): the place where it turns counts.
    void follow(double way) noexcept { farthest_ = std::max(farthest_, way); }
    /// A return was left and has not ended.
    [[nodiscard]] bool left() const noexcept { return left_; }
    /// The way that the walker has ahead when it turns, as expected when the return was left.
    [[nodiscard]] double expected() const noexcept { return left_at_ + goes_on_ * step_; }

    struct Done {
        double x_from_m, x_asked_m, x_to_m;
        double for_s;  // until the next drive was ordered
    };
    /// The return that was left, which is then over.
    Done end() noexcept {
        constexpr double learned = 0.5, most_periods = 8;  // share of the newest return; of run-out
        left_ = false;
        if (farthest_ > left_at_)  // else another return was ordered at once
            goes_on_ = std::min(std::lerp(goes_on_, (farthest_ - left_at_) / step_, learned), most_periods);
        const double forward = ahead_ == 0 ? -1 : 1;
        return {x_m_, x_m_ - forward * (target_ - way_), x_m_ - forward * (farthest_ - way_), for_s_};
    }
    [[nodiscard]] std::size_t ahead() const noexcept { return ahead_; }

private:
    double x_m_ = 0, way_ = 0, target_ = 0, step_ = 0, left_at_ = 0, farthest_ = 0;
    double from_s_ = 0, until_s_ = 0, for_s_ = 0;
    std::size_t ahead_ = 0;
    bool left_ = false;
    double goes_on_ = 3;  // periods that a walker goes on with its speed after an order
};

}  // namespace shaker::on_call
