#pragma once
// Output to the terminal of the user.
#include <string_view>

namespace shaker::ctl {

/// Writes to standard output at once. Throws NotWritten with the message of the C library.
void print(std::string_view text);

/// True if the reader of standard output has closed it.
bool nobody_reads() noexcept;

}  // namespace shaker::ctl
