#pragma once
// The content of an HDF5 file as text: for comparing two files.
#include <filesystem>
#include <string>

namespace shaker::test {

/// A line for each object, in alphabetical order: of a data set type, shape and the CRC-32C of its bytes, or
/// the value of a single number or text. Behind it a line for each attribute.
std::string text_of_hdf5(const std::filesystem::path& file);

}  // namespace shaker::test
