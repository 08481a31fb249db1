#pragma once
// The structural bytes of an HDF5 file and those with a checksum, as targets for a fuzzer.
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
    std::vector<Stretch> described;  // everything except values of data sets: headers, trees, heaps, gaps
    std::vector<Stretch> sealed;     // blocks whose last four bytes are the checksum of the others
};

/// Throws as drivers/replay/h5.hpp does when `file` is no sound HDF5 file.
Structure structure_of(const std::filesystem::path& file);

/// Corrects all checksums, as in deliberate damage. Blocks beyond the end are skipped.
void seal(std::string& bytes, const Structure& structure);

}  // namespace shaker::test
