#pragma once
// Recognises clients of other protocols on the instrument port: a browser that a web page sends there, and
// programs of binary protocols. A message of such a client could contain lines that are valid commands.
#include <string_view>

namespace shaker::scpi {

/// True if no line of text begins with this byte: the first byte of TLS and of STUN.
bool is_binary(char first) noexcept;

/// True if the start of a line is one of HTTP: "POST /" or "Host:", in capital or small letters, after any
/// blanks. The rest of the line need not be received.
bool begins_like_http(std::string_view line) noexcept;

/// The same for a complete line, which also may end like a request: "OPTIONS * HTTP/1.1".
bool is_http_line(std::string_view line) noexcept;

}  // namespace shaker::scpi
