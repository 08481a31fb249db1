#pragma once
// A drive whose samples are known, in what was recorded at the other end of a card.
#include <cstdint>
#include <string>
#include <vector>

namespace shaker {

/// Counts samples that are not zero.
struct DriveFound {
    std::int64_t exact = 0;    // equal to the drive, in order
    std::int64_t pieces = 0;   // number of contiguous pieces
    std::int64_t skipped = 0;  // of the drive, missing between two pieces
    std::int64_t foreign = 0;  // that do not belong to the drive
};

/// Compares the first channel of a recording (as find_pattern() reads it) with the codes of a drive.
DriveFound find_drive(const std::string& path, int bits, const std::vector<std::int32_t>& drive);

/// Codes in a file, native endian. Throw InputError.
void write_codes(const std::string& path, const std::vector<std::int32_t>& codes);
std::vector<std::int32_t> read_codes(const std::string& path);

}  // namespace shaker
