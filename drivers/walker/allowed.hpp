#pragma once
// Refusal of a value out of its range.
#include <string>

namespace shaker::walker {

/// Throws InputError "WHAT is VALUE; must be ALLOWED" unless good.
void require(bool good, const char* what, double value, const std::string& allowed);

}  // namespace shaker::walker
