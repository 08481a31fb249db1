#pragma once
// How a header is written in the table of commands: "[SOURce:]HARMonic<1..16>:AMPLitude".
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {

struct HeaderNode {
    Keyword keyword;
    std::string written;  // "HARMonic"
    bool optional = false;
    bool before = false;  // optional, and written "[SOURce:]": messages name it; "[:STATe]" they leave out
    int slot = -1;        // which of the header's numbers stands behind it; -1: none
    std::uint16_t first = 1, last = 1;  // of that number
};

using HeaderPattern = std::vector<HeaderNode>;

/// Throws InputError naming the header where it is not written as Command says.
HeaderPattern read_pattern(const std::string& header);

}  // namespace shaker::scpi
