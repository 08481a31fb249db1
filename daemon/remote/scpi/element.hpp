#pragma once
// One data element of a message, IEEE 488.2 chapter 7.7: what its first character says it is.
#include <string_view>

#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {

struct Element {
    enum class Form { number, word, string, block };

    Form form = Form::word;
    std::string_view raw;      // as it came
    double number = 0;         // decimal or #H #Q #B; infinite where it is more than a double holds
    std::string_view suffix;   // behind a decimal number
    std::string_view content;  // of a string, quotes undone, or of a block
    Mnemonic word;             // of a word that may be one: up to 12 characters
};

/// Takes the element at the begin of `text`, which is no blank. Throws Error -101 -102 -121 -123 -124 -131
/// -141 -151 -161 -170.
Element read_element(Text& text);

/// A decimal number with a unit, or without; blanks may stand before exponent and unit.
void read_decimal(Text& text, Element& element);
/// What is behind a # and no block: H, Q or B and its digits, at most 64 bits of them.
void read_nondecimal(Text& text, Element& element);

}  // namespace shaker::scpi
