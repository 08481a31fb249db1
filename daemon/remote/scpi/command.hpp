#pragma once
// One row of the table of commands, and the values after its header.
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "daemon/remote/scpi/parameter.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {

class Session;

/// Arguments of a handler.
struct Call {
    Session& session;
    std::span<const Argument> arguments;      // one per parameter of the row, optional ones included
    std::span<const std::uint16_t> suffixes;  // one for each <first..last> of the header; 1 where omitted
    Reply& reply;                             // a query writes at least one value; a command none
};

/// May throw Error and other exceptions of the program: InputError becomes -220, DeviceError -240, TripError
/// +101, all others -310.
using Handler = std::function<void(Call&)>;

/// Writes the answer of a query that failed, in the format of its usual answer.
using Placeholder = void (*)(Reply&);
/// n times NaN, written as 9.91E37.
template <int n>
void nans(Reply& reply) {
    for (int i = 0; i < n; ++i) reply.number(std::numeric_limits<double>::quiet_NaN());
}
/// "".
inline void empty_string(Reply& reply) { reply.string(""); }
/// A single NaN as written by Reply::numbers.
inline void nan_numbers(Reply& reply) { reply.numbers(std::array{std::numeric_limits<double>::quiet_NaN()}); }

/// Header such as "[SOURce:]HARMonic<1..16>:AMPLitude": capitals are the short form, parts in brackets are
/// optional, <first..last> is the range of the number after the mnemonic. Common commands are written "*IDN".
struct Command {
    std::string header;
    std::vector<Parameter> parameters = {};
    Handler set = {};    // empty: the header is a query only
    Handler query = {};  // empty: there is no query
    /// Parameters of the query. If empty and `parameters` is one numeric, "? MIN", "? MAX" and "? DEF" are
    /// answered from its bounds.
    std::vector<Parameter> query_parameters = {};
    /// Answer of a query that failed, besides its error, so that no client waits in vain.
    Placeholder without = nans<1>;
    bool guarded = false;  // `set` changes the bench: only for the holder of control
    bool urgent = false;   // runs at once, even after *WAI and *OPC?, for any client
    bool open = false;     // also for a client that must send the password first
};

inline constexpr std::size_t most_parameters = 8;

using Arguments = std::array<Argument, most_parameters>;

/// Reads the values up to the end of the unit; omitted optional values are set to their DEFault. Throws Error
/// without the command's name in its detail: -103 -108 -109, and those of read_element and to_argument.
std::span<const Argument> read_arguments(Text& text, std::span<const Parameter> parameters, Arguments& into);

/// Reads MIN, MAX or DEF after the query of a number; false without such a word.
bool read_bound(Text& text, Bound& bound);

}  // namespace shaker::scpi
