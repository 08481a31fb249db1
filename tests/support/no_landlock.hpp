#pragma once
// A kernel without Landlock, as seen by one thread and its children.
#include <functional>

namespace shaker::test {

/// Whether this kernel has Landlock.
bool has_landlock();

/// Runs `work` in a thread for which the kernel has no Landlock, and waits for it.
void without_landlock(const std::function<void()>& work);

}  // namespace shaker::test
