#include <iterator>
#include <string>
#include <utility>

#include "daemon/remote/scpi/session.hpp"
#include "daemon/remote/scpi/standard_commands.hpp"

namespace shaker::scpi {
namespace {

constexpr std::size_t longest_token = 1024;  // bytes

void next_error(Call& call) {
    const ErrorQueue::Entry entry = call.session.status().errors.pop();
    call.reply.integer(static_cast<int>(entry.code));
    call.reply.string(entry.text);
}

/// One header per line, with the marks of SCPI-99 21.10.1 for headers without query and for queries only.
void headers(Call& call) {
    std::string list;
    for (const Command& command : call.session.shared().tree.commands()) {
        if (!command.header.starts_with('*')) list += ':';
        list += command.header;
        if (!command.set) list += "?/qonly/";
        if (!command.query) list += "/nquery/";
        list += '\n';
    }
    call.reply.block(list);
}

/// ASCii accepts 9, its number of digits, or 0, which leaves the number to the instrument.
void set_format(Call& call) {
    const bool ascii = call.arguments[0].word == 0;
    const double standard = ascii ? 0 : 64;
    const double length = call.arguments[1].given ? call.arguments[1].number : standard;
    const bool known = ascii ? length == 0 || length == 9 : length == 32 || length == 64;
    if (!known)
        throw Error{Code::illegal_value, std::to_string(static_cast<int>(length)) +
                                             (ascii ? ", allowed 0 or 9" : ", allowed 32 or 64")};
    using Data = Format::Data;
    call.session.format().data = ascii ? Data::ascii : length == 32 ? Data::real32 : Data::real64;
}

void reply_format(Call& call) {
    const Format::Data data = call.session.format().data;
    call.reply.word(data == Format::Data::ascii ? "ASC" : "REAL");
    call.reply.integer(data == Format::Data::ascii ? 9 : data == Format::Data::real32 ? 32 : 64);
}

access::ControlLock& lock(const Call& call) { return call.session.shared().lock; }

}  // namespace

std::vector<Command> system_commands() {
    return {
        {.header = "SYSTem:ERRor[:NEXT]", .query = next_error, .open = true},
        {.header = "SYSTem:VERSion", .query = [](Call& call) { call.reply.word("1999.0"); }},
        {.header = "SYSTem:HELP:HEADers", .query = headers},
        {.header = "SYSTem:LOCK:REQuest",
         .query = [](Call& call) { call.reply.boolean(lock(call).request(call.session.name())); }},
        {.header = "SYSTem:LOCK:RELease", .set = [](Call& call) { lock(call).release(call.session.name()); }},
        {.header = "SYSTem:LOCK:OWNer", .query = [](Call& call) { call.reply.string(lock(call).owner()); }},
        {.header = "SYSTem:PASSword[:CENable]",
         .parameters = {string(longest_token)},
         .set = [](Call& call) { call.session.unlock(call.arguments[0].text); },
         .open = true},
        {.header = "SYSTem:PASSword:CDISable",
         .set = [](Call& call) { call.session.lock_again(); },
         .open = true},
        {.header = "SYSTem:PASSword:STATe",
         .query = [](Call& call) { call.reply.boolean(call.session.unlocked()); },
         .open = true},
        {.header = "FORMat[:DATA]",
         .parameters = {choice("ASCii|REAL"), optional(integer(0, 64))},
         .set = set_format,
         .query = reply_format},
        {.header = "FORMat:BORDer",
         .parameters = {choice("NORMal|SWAPped")},
         .set = [](Call& call) { call.session.format().swapped = call.arguments[0].word == 1; },
         .query = [](Call& call) { call.reply.word(call.session.format().swapped ? "SWAP" : "NORM"); }},
    };
}

std::vector<Command> with_standard_commands(std::vector<Command> own) {
    std::vector<Command> all = common_commands();
    for (std::vector<Command> rows : {status_commands(), system_commands(), std::move(own)})
        all.insert(all.end(), std::move_iterator{rows.begin()}, std::move_iterator{rows.end()});
    return all;
}

}  // namespace shaker::scpi
