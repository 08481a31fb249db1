#include "daemon/reduction/period_fold.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace shaker::reduction {

void PeriodFold::enter(int k) noexcept {
    k_ = k;
    frames_ = 0;
    area_ = variance_ = 0;
}

std::optional<PeriodFold::Period> PeriodFold::finish(double t_s, double x_m) noexcept {
    const double end = start_s_ + (k_ + 1) * period_s_;
    const double x_end = last_x_ + (x_m - last_x_) * (end - last_t_) / (t_s - last_t_);
    area_ += (end - last_t_) * (last_x_ + x_end) / 2;
    last_t_ = end;
    last_x_ = x_end;
    Period done{k_, frames_, area_ / period_s_, {}};
    most_frames_ = std::max(most_frames_, frames_);
    const bool usable = whole_ && frames_ > 0 && frames_ >= 0.9 * most_frames_;
    const double variance = frames_ > 0 ? variance_ / (static_cast<double>(frames_) * frames_) : 0.0;
    if (usable && before_ && before_->k + 1 == k_) {
        done.drift = {done.mean_m - before_->mean_m, std::sqrt(variance + before_variance_)};
    }
    before_.reset();
    if (usable) {
        before_ = done;
        before_variance_ = variance;
    }
    return done;
}

std::optional<PeriodFold::Period> PeriodFold::add(double t_s, double x_m, double sd_m) noexcept {
    std::optional<Period> done;
    if (any_ && t_s < last_t_) {
        any_ = false;
        before_.reset();
    }
    const int k = static_cast<int>(std::floor(std::max((t_s - start_s_) / period_s_, -1.0)));
    if (any_ && k > k_) {
        if (k_ >= 0) {
            done = finish(t_s, x_m);
        } else {
            const double x0 = last_x_ + (x_m - last_x_) * (start_s_ - last_t_) / (t_s - last_t_);
            last_t_ = start_s_;
            last_x_ = x0;
        }
        whole_ = k == k_ + 1;
        enter(k);
    } else if (!any_) {
        whole_ = std::abs(t_s - start_s_) < 1e-9 * period_s_;
        enter(k);
    }
    if (k >= 0) {
        if (any_) area_ += (t_s - last_t_) * (x_m + last_x_) / 2;
        variance_ += sd_m * sd_m;
        ++frames_;
    }
    any_ = true;
    last_t_ = t_s;
    last_x_ = x_m;
    return done;
}

namespace {

constexpr std::size_t needed = 6;

// Standard deviation of one drift about a smooth approach, from the second differences of the newest ones.
double scatter_of(std::span<const double, 2 * needed> D) noexcept {
    std::array<double, 2 * needed - 2> bends{};
    for (std::size_t i = 0; i < bends.size(); ++i) bends[i] = std::abs(D[i + 2] - 2 * D[i + 1] + D[i]);
    std::ranges::nth_element(bends, bends.begin() + needed - 1);
    return bends[needed - 1] / (0.6745 * std::sqrt(6.0));  // 0.6745: median of |x|, x normal
}

// The newest drifts, many of them: their two halves agree, and they do not all go one way.
bool agree(std::span<const double> D, double sigma) noexcept {
    const std::size_t half = D.size() / 2;
    double before = 0, now = 0;
    for (std::size_t i = 0; i < half; ++i) {
        before += D[i] / static_cast<double>(half);
        now += D[half + i] / static_cast<double>(half);
    }
    for (std::size_t i = half; i < D.size(); ++i)
        if (std::abs(D[i] - D[i - 1]) > 3 * sigma * std::sqrt(2.0)) return false;
    if (std::abs(now - before) > 2 * sigma * std::sqrt(2.0 / static_cast<double>(half))) return false;
    const auto five = D.last(5);
    const bool rising = std::adjacent_find(five.begin(), five.end(), std::greater_equal<>()) == five.end();
    const bool falling = std::adjacent_find(five.begin(), five.end(), std::less_equal<>()) == five.end();
    return !rising && !falling;
}

}  // namespace

bool settled(std::span<const double> D, double sigma) noexcept {
    constexpr double clear = 2;  // times sigma: the walker's own scatter
    const auto finite = [](std::span<const double> d) {
        return std::ranges::all_of(d, [](double x) { return std::isfinite(x); });
    };
    if (D.size() < needed || !(sigma > 0) || !finite(D.last(needed))) return false;
    if (agree(D.last(needed), sigma)) return true;
    if (D.size() < 2 * needed || !finite(D.last(2 * needed))) return false;
    const double own = scatter_of(D.last<2 * needed>());
    return own > clear * sigma && agree(D.last(2 * needed), own);
}

}  // namespace shaker::reduction
