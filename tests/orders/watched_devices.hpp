#pragma once
// Devices of the simulated bench with an observer between them and the daemon.
#include <functional>
#include <memory>

#include "drivers/devices.hpp"
#include "tests/orders/laws.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::orders {

/// Heap calls between two points of a real-time step.
class HeapWatch {
public:
    void begin(const char* step) noexcept {
        step_ = step;
        before_ = test::heap_calls();
    }
    void end(Laws& laws) {
        if (step_ == nullptr) return;
        const test::HeapCalls after = test::heap_calls();
        const std::uint64_t calls = after.taken - before_.taken + after.returned - before_.returned;
        const char* step = std::exchange(step_, nullptr);
        if (calls > 0) laws.allocated(step, calls);
    }
    void forget() noexcept { step_ = nullptr; }

private:
    const char* step_ = nullptr;
    test::HeapCalls before_{};
};

/// What all watched devices share.
struct Watch {
    Laws& laws;
    HeapWatch heap{};
    std::function<bool(std::size_t trouble)> troubled;  // whether a trouble of the computer lasts now
    std::function<void()> meanwhile;                    // the other threads run while the output waits
};

/// Puts the watch between the daemon and each device of a rig.
void watch_devices(Rig& rig, Watch& watch);

}  // namespace shaker::orders
