#pragma once
// An independent walker for tests: long double, no tables; roots by bisection after a fine scan.
#include <vector>

#include "drivers/walker/walker.hpp"

namespace shaker {

/// Steps a setting through whole periods in long double. It scans each period in equal steps and
/// searches for an extremum of v_R between two of them. It is slow, and misses intervals below a step
/// squared.
class FineWalker {
public:
    explicit FineWalker(const walker::WalkerSetting& setting, long double v = 0, int steps = 2000);
    /// D of the next period, m.
    long double advance_period();
    [[nodiscard]] long double v() const noexcept { return v_; }
    [[nodiscard]] int contact() const noexcept { return s_; }
    /// Events of the last period: phase t/T, from, to.
    struct Event {
        long double phase;
        int from;
        int to;
    };
    [[nodiscard]] const std::vector<Event>& events() const noexcept { return events_; }

private:
    struct Term {
        int q;
        long double amplitude, phase;
    };
    [[nodiscard]] long double a_base(long double theta) const;
    [[nodiscard]] long double v_base(long double theta) const;
    [[nodiscard]] long double x_base(long double theta) const;
    [[nodiscard]] long double normal(long double theta) const;
    [[nodiscard]] long double drive_margin(long double theta) const;  // |a_B - g sin b| - mu_s n
    [[nodiscard]] long double v_slip(long double theta) const;        // from the segment's start
    [[nodiscard]] long double x_slip(long double theta) const;
    [[nodiscard]] long double v_rel(long double theta) const { return v_slip(theta) - v_base(theta); }
    [[nodiscard]] long double v_rel_rate(long double theta) const;  // dv_R/dt in slip
    [[nodiscard]] bool slip_ends_in(long double a, long double b, long double& at) const;
    void switch_to(int s, long double theta, long double v, long double x);
    void meet_base(long double theta);
    void release(long double theta);

    walker::WalkerSetting setting_;
    std::vector<Term> base_, vertical_;
    long double omega_;
    int steps_;
    int s_ = 0;
    long double start_ = 0, v_start_ = 0, x_start_ = 0;  // of the segment
    long double v_ = 0;
    std::vector<Event> events_;
};

}  // namespace shaker
