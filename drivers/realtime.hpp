#pragma once
// Real-time settings of the process and its threads. Each function requests one thing of the kernel and
// returns an empty text when granted, else what was refused and how to allow it. None throws: a run works
// without these, with more jitter, and reports it.
#include <pthread.h>

#include <cstddef>
#include <string>

namespace shaker {

/// SCHED_FIFO priorities of the threads on hardware, 1 to 99; the thread that watches a thread's share has
/// one more. systemd/shakerd.service allows them.
namespace fifo_priority {
inline constexpr int output = 70;
inline constexpr int abort_input = 66;
inline constexpr int accelerometer = 64;
inline constexpr int doors = 60;             // reads aborts: above pictures
inline constexpr int picture_receiver = 55;  // a library's thread: below all that stops the drive
inline constexpr int camera = 50;
inline constexpr int recorder = 20;
}  // namespace fifo_priority

/// Keeps present and future memory of the process out of swap. Requested only if the limit on locked
/// memory is unlimited or can be made so: under a limit, later allocations would fail.
[[nodiscard]] std::string lock_memory() noexcept;

/// Sets a thread to SCHED_FIFO at a priority of 1 to 99, above all ordinary threads.
[[nodiscard]] std::string use_fifo_priority(int priority, pthread_t thread = pthread_self()) noexcept;

/// Sets a thread to ordinary scheduling.
void use_ordinary_priority(pthread_t thread = pthread_self()) noexcept;

/// Processor time of the calling thread, s.
[[nodiscard]] double thread_time_s() noexcept;

/// Names the calling thread for debuggers and `ps -L`; at most 15 characters.
[[nodiscard]] std::string name_thread(const std::string& name) noexcept;

/// Touches the next `bytes` of the calling thread's stack, to avoid page faults later.
[[nodiscard]] std::string prefault_stack(std::size_t bytes) noexcept;

}  // namespace shaker
