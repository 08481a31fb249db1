#pragma once
// A kernel without some of its system calls, as seen by one thread and its children.
#include <functional>

namespace shaker::test {

/// Whether this kernel has Landlock.
bool has_landlock();

/// Runs `work` in a thread for which the kernel answers `call` with this errno, and waits for it.
void without_call(int call, int error, const std::function<void()>& work);

/// The same without Landlock.
void without_landlock(const std::function<void()>& work);

}  // namespace shaker::test
