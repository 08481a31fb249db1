#pragma once
// Cost of a piece of work: the median over repeats of this thread's processor time. Other programs on the
// machine do not add to it, but they may evict its caches.
#include <algorithm>
#include <ctime>
#include <vector>

namespace shaker::bench {

/// Processor time of this thread so far, ns.
inline double cpu_ns() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

/// Median cost of one call of `work` over an odd number of repeats, ns, after one call that is not counted.
template <class Work>
double median_cost_ns(int repeats, Work work) {
    work();
    std::vector<double> costs;
    for (int i = 0; i < repeats; ++i) {
        const double before = cpu_ns();
        work();
        costs.push_back(cpu_ns() - before);
    }
    const auto middle = costs.begin() + static_cast<std::ptrdiff_t>(costs.size() / 2);
    std::nth_element(costs.begin(), middle, costs.end());
    return *middle;
}

}  // namespace shaker::bench
