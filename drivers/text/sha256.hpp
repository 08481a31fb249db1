#pragma once
// Checksum by which a changed text is noticed.
#include <string>

namespace shaker::text {

/// SHA-256 of the bytes of a text, as 64 hexadecimal digits.
std::string sha256(const std::string& text);

}  // namespace shaker::text
