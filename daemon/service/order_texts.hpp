#pragma once
// Checks of texts that may come from a network: names of recordings, and remarks.
#include <string>

namespace shaker::service {

/// A recording's name: 1 to 64 letters, digits, dots, hyphens and underscores, no dot in front. InputError
/// with the name otherwise.
void require_name(const std::string& name);
/// A remark: 1 to 400 bytes of UTF-8 without control characters. InputError otherwise.
void require_remark(const std::string& text);

}  // namespace shaker::service
