#pragma once
// What a thread asks of the kernel before it may be called real-time. Each function asks for one thing and
// returns what was refused, in words that say what to change; an empty text means granted. None throws: a
// session runs without these, only less punctually, and says so.
#include <cstddef>
#include <string>

namespace shaker {

/// Keeps all memory of the process, present and future, out of swap. Asked for only when the limit on locked
/// memory is (or can be made) unlimited: under a limit, later allocations would fail.
[[nodiscard]] std::string lock_memory() noexcept;

/// Schedules the calling thread first in, first out, at a priority of 1 to 99, above all ordinary threads.
[[nodiscard]] std::string use_fifo_priority(int priority) noexcept;

/// Names the calling thread, as debuggers and `ps -L` show it; at most 15 characters.
[[nodiscard]] std::string name_thread(const std::string& name) noexcept;

/// Touches the calling thread's next `bytes` of stack, so that no page of it is missing later.
[[nodiscard]] std::string prefault_stack(std::size_t bytes) noexcept;

}  // namespace shaker
