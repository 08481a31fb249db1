#pragma once
// Image: an HDF5 file made in memory, whose bytes are then written by checked calls. HDF5 therefore never
// meets a full disk, after which it can lose data and crash at the end of the program.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/descriptor.hpp"
#include "drivers/recorded/h5/h5.hpp"

namespace shaker::h5 {

class Image {
public:
    /// alignment: bytes; every object in the file begins at a multiple of it.
    explicit Image(hsize_t alignment = 1);
    /// The file, for adding objects.
    [[nodiscard]] hid_t id() const noexcept { return file_.get(); }
    /// Bytes of the whole file. Space that was reserved early and not written counts, but uses no memory.
    [[nodiscard]] std::uint64_t size() const;
    /// The complete first `bytes` of the file.
    [[nodiscard]] std::vector<std::byte> head(std::uint64_t bytes) const;

private:
    Descriptor memory_;
    Handle file_;
};

}  // namespace shaker::h5
