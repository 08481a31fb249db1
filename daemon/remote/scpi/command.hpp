#pragma once
// One row of the table of commands.
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "daemon/remote/scpi/parameter.hpp"

namespace shaker::scpi {

class Reply;
class Session;

/// What a handler is called with.
struct Call {
    Session& session;
    std::span<const Argument> arguments;  // as many as the row has parameters, optional ones included
    std::span<const std::uint16_t>
        suffixes;  // one for each <first..last> of the header, 1 where it was left out
    Reply& reply;  // a query writes at least one value; a command none
};

/// May throw Error, and what the rest of the programme throws: InputError becomes -220, DeviceError -240,
/// TripError +101, anything else -310.
using Handler = std::function<void(Call&)>;

/// "[SOURce:]HARMonic<1..16>:AMPLitude": capitals are the short form, what is in brackets may be left out,
/// and <first..last> is a number behind the mnemonic. Common commands are written "*IDN".
struct Command {
    std::string header;
    std::vector<Parameter> parameters = {};
    Handler set = {};    // none: the header is a query only
    Handler query = {};  // none: there is no query
    /// Of the query. Where this is empty and `parameters` is one numeric, "? MIN", "? MAX" and "? DEF" are
    /// answered from its bounds.
    std::vector<Parameter> query_parameters = {};
    bool guarded = false;  // `set` changes what the bench does: only for who holds control
    bool urgent = false;   // `set` runs at once, also behind *WAI and *OPC?; whoever holds control
};

inline constexpr std::size_t most_parameters = 8;

}  // namespace shaker::scpi
