#pragma once
// What a command takes: kinds of parameters with their units, bounds and words, and the values that came.
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "daemon/remote/scpi/element.hpp"
#include "daemon/remote/scpi/unit.hpp"

namespace shaker::scpi {

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
    double standard = std::numeric_limits<double>::quiet_NaN();  // DEFault; NaN: there is none
    std::vector<Keyword> words = {};  // of a choice; those a number takes instead of figures
    std::size_t longest = 255;        // bytes of a string or a block
    bool optional = false;            // so are all behind it

    [[nodiscard]] bool numeric() const noexcept { return kind == Kind::number || kind == Kind::integer; }
};

Parameter number(std::string_view unit, double min, double max, double standard = std::nan(""));
Parameter integer(double min, double max, double standard = std::nan(""));
Parameter boolean();
/// `words` as manuals write them: "SINusoid|BIHarmonic|NONE".
Parameter choice(std::string_view words);
Parameter string(std::size_t longest = 255);
Parameter block(std::size_t longest);
/// The same, but a client may leave it out: Argument::given says whether it did.
Parameter optional(Parameter parameter);
/// A number or one of `words`: or_word("AUTO", integer(1, 100)).
Parameter or_word(std::string_view words, Parameter parameter);

/// One value as it came, checked. Views are into the message: they last until the handler returns.
struct Argument {
    bool given = false;
    double number = 0;           // number (in the parameter's unit), integer
    bool on = false;             // boolean
    int word = -1;               // place in Parameter::words; -1: figures came
    std::string_view text = {};  // string, block
};

/// Throws Error, its detail without the command's name: the kind's ...-not-allowed, -104, -131, -138, -141,
/// -222, -223, -224.
Argument to_argument(const Element& element, const Parameter& parameter);

enum class Bound { minimum, maximum, standard };
/// Whether a word is MINimum, MAXimum or DEFault.
bool is_bound(const Mnemonic& word, Bound& bound) noexcept;
/// Throws Error -224 where the parameter has no such bound.
double value_of(const Parameter& parameter, Bound bound);

}  // namespace shaker::scpi
