#pragma once
// The values of a message: as received (IEEE 488.2 chapter 7.7), and checked against what a command allows.
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "daemon/remote/scpi/text.hpp"
#include "daemon/remote/scpi/unit.hpp"

namespace shaker::scpi {

/// One data element of a message; its first character determines the kind.
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

enum class Kind {
    number,   // with a unit; also MINimum, MAXimum, DEFault
    integer,  // rounded to the nearest; also MINimum, MAXimum, DEFault
    boolean,  // ON, OFF or a number, which is on unless it rounds to 0
    choice,   // one of `words`
    string,   // "..." or '...'
    block,    // #<n><length><data> or #0<data>
};

struct Parameter {
    Kind kind = Kind::number;
    Unit unit = Unit{};
    double min = -std::numeric_limits<double>::infinity();  // in `unit`, both included
    double max = std::numeric_limits<double>::infinity();
    double standard = std::numeric_limits<double>::quiet_NaN();  // DEFault; NaN: none
    std::vector<Keyword> words = {};  // of a choice; of a number: words allowed instead of figures
    std::size_t longest = 255;        // bytes of a string or a block
    bool optional = false;            // all parameters after it are optional too

    [[nodiscard]] bool numeric() const noexcept { return kind == Kind::number || kind == Kind::integer; }
};

Parameter number(std::string_view unit, double min, double max, double standard = std::nan(""));
Parameter integer(double min, double max, double standard = std::nan(""));
Parameter boolean();
/// `words` in the notation of manuals: "SINusoid|BIHarmonic|NONE".
Parameter choice(std::string_view words);
Parameter string(std::size_t longest = 255);
Parameter block(std::size_t longest);
/// The same parameter, optional; Argument::given shows whether a value was sent.
Parameter optional(Parameter parameter);
/// A number or one of `words`: or_word("AUTO", integer(1, 100)).
Parameter or_word(std::string_view words, Parameter parameter);

/// One checked value. Views are into the message and valid until the handler returns.
struct Argument {
    bool given = false;
    double number = 0;           // number (in the parameter's unit), integer
    bool on = false;             // boolean
    int word = -1;               // index in Parameter::words; -1: figures
    std::string_view text = {};  // string, block
};

/// Throws Error without the command's name in its detail: the kind's ...-not-allowed, -104, -131, -138, -141,
/// -222, -223, -224.
Argument to_argument(const Element& element, const Parameter& parameter);

enum class Bound { minimum, maximum, standard };
/// True if a word is MINimum, MAXimum or DEFault.
bool is_bound(const Mnemonic& word, Bound& bound) noexcept;
/// Throws Error -224 if the parameter does not have this bound.
double value_of(const Parameter& parameter, Bound bound);

}  // namespace shaker::scpi
