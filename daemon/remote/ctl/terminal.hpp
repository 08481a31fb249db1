#pragma once
// Output to the terminal of the user.
#include <string>
#include <string_view>

namespace shaker::ctl {

/// The text with control sequences and invalid UTF-8 written as text: ESC becomes \x1b, a change of the
/// writing direction \u202e. Line ends are kept if `lines` is true.
std::string printable(std::string_view text, bool lines = false);

/// Writes to standard output at once. Throws NotWritten with the message of the C library.
void print(std::string_view text);

/// True if the reader of standard output has closed it.
bool nobody_reads() noexcept;

}  // namespace shaker::ctl
