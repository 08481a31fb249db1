#pragma once
// An HDF5 file made in memory, whose bytes are then put on the disk by checked calls of our own: HDF5 never
// meets a full disk, after which it can lose what it held and crash at the end of the program.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/replay/h5.hpp"

namespace shaker::h5 {

class Image {
public:
    /// alignment: every object in the file begins at a multiple of this, bytes.
    explicit Image(hsize_t alignment = 1);
    ~Image();
    Image(const Image&) = delete;
    Image& operator=(const Image&) = delete;
    /// The file, to be filled as any other.
    [[nodiscard]] hid_t id() const noexcept { return file_.get(); }
    /// Bytes of the whole file. Room that was reserved early and not written counts, but takes no memory.
    [[nodiscard]] std::uint64_t size() const;
    /// Its first `bytes`, complete.
    [[nodiscard]] std::vector<std::byte> head(std::uint64_t bytes) const;

private:
    int memory_;
    Handle file_;
};

}  // namespace shaker::h5
