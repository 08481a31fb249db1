#pragma once
// What goes to the user's terminal.
#include <string>
#include <string_view>

namespace shaker::ctl {

/// The text with everything spelled out that a terminal would obey or that is not UTF-8: ESC becomes \x1b, a
/// change of the writing direction \u202e. Line ends stay where `lines` says so.
std::string printable(std::string_view text, bool lines = false);

/// Writes to standard output at once. NotWritten with the C library's words.
void print(std::string_view text);

/// Whoever read standard output has gone.
bool nobody_reads() noexcept;

}  // namespace shaker::ctl
