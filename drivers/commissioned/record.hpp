#pragma once
// The record of a bench's commissioning: a file beside its rig file, valid while that file is unchanged.
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::commissioned {

/// One test and its result as text.
struct Item {
    std::string name, result;
};

/// "bench.toml" has its record in "bench.toml.commissioned".
std::filesystem::path record_of(const std::filesystem::path& rig);

/// Writes the record for this content of the rig file, as TOML: date (ISO 8601), rig_sha256, [[item]] name,
/// result. DeviceError when the record cannot be written.
void write_record(const std::filesystem::path& rig, const std::string& rig_text, const std::string& date,
                  const std::vector<Item>& items);

/// The reason why a rig file with this content counts as not commissioned, with the remedy; empty: its record
/// is valid.
std::string missing_record(const std::filesystem::path& rig, const std::string& rig_text);

}  // namespace shaker::commissioned
