#pragma once
// Real-time settings of the process and its threads. Each function requests one thing of the kernel and
// returns an empty text when granted, else what was refused and how to allow it. None throws: a run works
// without these, with more jitter, and reports it.
#include <cstddef>
#include <string>

namespace shaker {

/// Keeps present and future memory of the process out of swap. Requested only if the limit on locked
/// memory is unlimited or can be made so: under a limit, later allocations would fail.
[[nodiscard]] std::string lock_memory() noexcept;

/// Sets the calling thread to SCHED_FIFO at a priority of 1 to 99, above all ordinary threads.
[[nodiscard]] std::string use_fifo_priority(int priority) noexcept;

/// Sets the calling thread to ordinary scheduling.
void use_ordinary_priority() noexcept;

/// Processor time of the calling thread, s.
[[nodiscard]] double thread_time_s() noexcept;

/// Names the calling thread for debuggers and `ps -L`; at most 15 characters.
[[nodiscard]] std::string name_thread(const std::string& name) noexcept;

/// Touches the next `bytes` of the calling thread's stack, to avoid page faults later.
[[nodiscard]] std::string prefault_stack(std::size_t bytes) noexcept;

}  // namespace shaker
