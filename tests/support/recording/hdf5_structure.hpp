#pragma once
// Which bytes of an HDF5 file describe it, and which of those carry a checksum: what a fuzzer aims at.
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::test {

/// Bytes `begin` to `end`, not included, of a file.
struct Stretch {
    std::size_t begin, end;
};

struct Structure {
    std::vector<Stretch> described;  // all that is not values of data sets: headers, trees, heaps, gaps
    std::vector<Stretch> sealed;     // blocks whose last four bytes are the checksum of the others
};

/// Throws as drivers/replay/h5.hpp does when `file` is no sound HDF5 file.
Structure structure_of(const std::filesystem::path& file);

/// Makes all checksums right again, as whoever damages a file on purpose does. Blocks beyond the end are
/// left.
void seal(std::string& bytes, const Structure& structure);

}  // namespace shaker::test
