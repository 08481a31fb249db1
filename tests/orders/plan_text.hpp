#pragma once
// A plan as text: the files of tests/orders/plans, and the report of a broken law.
//
//   # law: why it broke; lines that begin with # are comments
//   plan seed=1 length_s=4 frequency_hz=10 identifies=no buffer_s=0 kept_s=0
//   move at_s=1 client=2 action=start value=0.5
//   fault at_s=1.95 what=saturated for_s=0.2 value=0
//
// The keys are those of Plan, Move and Fault, in this order; only `at_edge` and `enable_s` may be missing.
// Moves and faults are in the order of time.
#include <filesystem>
#include <string>

#include "tests/orders/laws.hpp"
#include "tests/orders/plan.hpp"

namespace shaker::orders {

/// Every number in full: plan_from_text() gives an equal plan if moves and faults are in the order of time.
std::string text(const Plan& plan);
/// Throws InputError with the line, the value and what was expected.
Plan plan_from_text(const std::string& text);

/// Reads a file. Throws InputError with its name.
Plan read_plan(const std::filesystem::path& file);
/// Writes a file whose comment is the broken law, and creates its folder if needed.
void write_plan(const std::filesystem::path& file, const Plan& plan, const Violation& why);
/// All files of a folder, by name.
std::vector<std::filesystem::path> plans_in(const std::filesystem::path& folder);

}  // namespace shaker::orders
