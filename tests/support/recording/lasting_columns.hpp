#pragma once
// Columns of a recording that grow during the run and are never overwritten.
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::test {

/// Paths of these columns. The recording is finished.
std::vector<std::string> lasting_columns(const recorded::RecordingReader& file);

/// Number of equal complete rows at the start.
std::uint64_t same_rows(const h5::Bytes& is, const h5::Bytes& was);

}  // namespace shaker::test
