#pragma once
// Checks of the disk after a run: finished recordings replay to the bit, and a killed program has left all
// that it had acknowledged.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace shaker::orders {

/// Damage of a finished recording, and whether its replay differs; one sentence each.
std::vector<std::string> faults_of(const std::filesystem::path& file);

/// What the reader of journals says of the campaigns in a folder, one sentence each. made: each must have its
/// table of points.
std::vector<std::string> faults_of_campaigns(const std::filesystem::path& folder, bool made);

/// Number of files and of their parts that the daemon's library of files still has open in this process.
std::size_t left_open() noexcept;

/// Recovers a recording that may be open. False: refused.
bool recovers(const std::filesystem::path& file);

/// The folder of a killed program: recovers what was being recorded and checks each recording. remarks: those
/// that the bench accepted, with their virtual times, s. Each must be in
/// the recording that was open, or in an earlier one.
std::vector<std::string> lost_after_kill(const std::filesystem::path& folder,
                                         const std::vector<std::pair<double, std::string>>& remarks);

}  // namespace shaker::orders
