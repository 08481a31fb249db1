#pragma once
// Text of files and clients, made safe for a terminal or a log.
#include <cstddef>
#include <string>
#include <string_view>

namespace shaker {

/// The text with control characters (C0, DEL, C1), line separators, changes of the writing direction and
/// invalid UTF-8 written as text: ESC becomes \x1b, CSI \u009b, the byte ff \xff. DEL becomes \u007f, so JSON
/// stays JSON. Line ends and tabs are kept if `lines` is true.
std::string printable(std::string_view text, bool lines = false);

/// Number of bytes at the end of `text` that begin a character of UTF-8 and do not end it: 0 to 3.
std::size_t unfinished_bytes(std::string_view text) noexcept;

}  // namespace shaker
