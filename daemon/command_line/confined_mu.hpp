#pragma once
// Rights of a child that reads the points of campaigns.
#include <filesystem>
#include <vector>

#include "daemon/sandbox/confined.hpp"

namespace shaker::command_line {

/// For reading these points tables, all in one child.
sandbox::Confinement confinement_for_points(const std::vector<std::filesystem::path>& files);

}  // namespace shaker::command_line
