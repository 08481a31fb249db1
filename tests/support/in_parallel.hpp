#pragma once
// Runs several pieces of work at a time.
#include <atomic>
#include <thread>
#include <vector>

namespace shaker::test {

/// Calls work(0) to work(count - 1), `jobs` of them at a time. `work` does not throw.
template <class Work>
void in_parallel(int count, int jobs, Work work) {
    std::atomic<int> next{0};
    std::vector<std::jthread> threads;
    threads.reserve(static_cast<std::size_t>(jobs));
    for (int j = 0; j < jobs; ++j)
        threads.emplace_back([&] {
            for (int i = next++; i < count; i = next++) work(i);
        });
}

}  // namespace shaker::test
