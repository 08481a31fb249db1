#pragma once
// Reads a plan. daemon/campaign/README.md describes the format.
#include <filesystem>
#include <string>
#include <string_view>

#include "daemon/campaign/plan.hpp"

namespace shaker::campaign {

inline constexpr int most_steps = 10'000;    // of a range
inline constexpr int most_repeats = 10'000;  // of a series

/// InputError with file, line, key, value and what is allowed: for unknown keys, values out of range or given
/// twice, empty lists, a number of periods beside a precision, a range without steps, and a list of order
/// mirror that has a mirror partner.
Plan read_plan(const std::filesystem::path& file);
Plan parse_plan(std::string_view text, const std::string& file_name);

}  // namespace shaker::campaign
