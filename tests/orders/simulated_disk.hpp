#pragma once
// A disk that fails on command, for the files of this program: its calls of write, synchronise and free space
// pass through here.
#include <cstdint>

namespace shaker::orders {

enum class Disk : std::uint8_t {
    good,
    full,    // nothing can be written, and no space is free
    failing  // writing and synchronising fail
};

/// False where calls cannot be replaced (sanitisers): the disk is then always good.
bool disk_can_fail() noexcept;
/// For all threads, from now on.
void set_disk(Disk disk) noexcept;

}  // namespace shaker::orders
