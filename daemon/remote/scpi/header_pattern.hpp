#pragma once
// Parses a header of the table of commands: "[SOURce:]HARMonic<1..16>:AMPLitude".
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/remote/scpi/data/text.hpp"

namespace shaker::scpi {

struct HeaderNode {
    Keyword keyword;
    std::string written;  // "HARMonic"
    bool optional = false;
    bool before = false;  // optional and written "[SOURce:]": shown in messages; "[:STATe]" is not
    int slot = -1;        // index of the number after it in the header; -1: none
    std::uint16_t first = 1, last = 1;  // range of that number
};

using HeaderPattern = std::vector<HeaderNode>;

/// Throws InputError with the header if it is not in the notation of Command.
HeaderPattern read_pattern(const std::string& header);

}  // namespace shaker::scpi
