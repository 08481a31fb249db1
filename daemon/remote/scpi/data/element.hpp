#pragma once
// One data element of a message, IEEE 488.2 chapter 7.7; its first character determines the kind.
#include <string_view>

#include "daemon/remote/scpi/data/text.hpp"

namespace shaker::scpi {

struct Element {
    enum class Form { number, word, string, block };

    Form form = Form::word;
    std::string_view raw;      // as received
    double number = 0;         // decimal or #H #Q #B; infinite if too large for a double
    std::string_view suffix;   // after a decimal number
    std::string_view content;  // of a string, without quotes, or of a block
    Mnemonic word;             // of a word with up to 12 characters
};

/// Reads the element at the start of `text`, which must not be a blank. Throws Error -101 -102 -121 -123 -124
/// -131 -141 -151 -161 -170.
Element read_element(Text& text);

/// A decimal number with or without a unit; blanks are allowed before exponent and unit.
void read_decimal(Text& text, Element& element);
/// A number after # that is not a block: H, Q or B and its digits, at most 64 bits.
void read_nondecimal(Text& text, Element& element);

}  // namespace shaker::scpi
