#include "daemon/remote/scpi/standard_commands.hpp"

#include <iterator>
#include <string>
#include <utility>

#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker::scpi {

namespace {

constexpr double largest_byte = 255, last_place = 9;

void clear(Call& call) {
    call.session.forget_operation();
    call.session.status().clear();
}

void reset(Call& call) {
    call.session.forget_operation();
    call.session.format() = {};
    call.session.shared().instrument.reset(call.session);
}

/// Pauses the session until all orders are done. False when they are done already.
bool pause(const Call& call, std::function<void(Reply&)> reply) {
    Instrument& instrument = call.session.shared().instrument;
    if (!instrument.pending()) return false;
    call.session.pause({[&instrument] { return !instrument.pending(); }, std::move(reply)});
    return true;
}

void when_complete(Call& call) {
    const auto done = [](Reply& reply) { reply.integer(1); };
    if (!pause(call, done)) done(call.reply);
}

void wait(Call& call) { static_cast<void>(pause(call, {})); }

std::uint8_t byte(const Call& call) { return static_cast<std::uint8_t>(call.arguments.front().number); }
int place(const Call& call) { return static_cast<int>(call.arguments.front().number); }

constexpr double largest_mask = 65535;

using Register = StatusRegister StatusModel::*;

StatusRegister& of(const Call& call, Register which) { return call.session.status().*which; }

Command masked(const std::string& header, Register which, void (StatusRegister::*write)(std::uint16_t),
               std::uint16_t (StatusRegister::*read)() const) {
    return {.header = header,
            .parameters = {integer(0, largest_mask)},
            .set =
                [=](Call& call) {
                    (of(call, which).*write)(static_cast<std::uint16_t>(call.arguments.front().number));
                },
            .query = [=](Call& call) { call.reply.integer((of(call, which).*read)()); }};
}

void add(std::vector<Command>& rows, const std::string& group, Register which) {
    rows.push_back({.header = group + "[:EVENt]",
                    .query = [=](Call& call) { call.reply.integer(of(call, which).take_event()); }});
    rows.push_back({.header = group + ":CONDition",
                    .query = [=](Call& call) { call.reply.integer(of(call, which).condition()); }});
    rows.push_back(masked(group + ":ENABle", which, &StatusRegister::enable, &StatusRegister::enabled));
    rows.push_back(
        masked(group + ":PTRansition", which, &StatusRegister::filter_rising, &StatusRegister::rising));
    rows.push_back(
        masked(group + ":NTRansition", which, &StatusRegister::filter_falling, &StatusRegister::falling));
}

void preset(Call& call) {
    call.session.status().operation.preset();
    call.session.status().questionable.preset();
}

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

std::vector<Command> common_commands() {
    const std::vector<Parameter> mask{integer(0, largest_byte)}, memory{integer(0, last_place)};
    return {
        {.header = "*CLS", .set = clear, .open = true},
        {.header = "*ESE",
         .parameters = mask,
         .set = [](Call& call) { call.session.status().set_event_mask(byte(call)); },
         .query = [](Call& call) { call.reply.integer(call.session.status().event_mask()); }},
        {.header = "*ESR",
         .query = [](Call& call) { call.reply.integer(call.session.status().take_events()); },
         .open = true},
        {.header = "*IDN",
         .query = [](Call& call) { call.reply.word(call.session.shared().instrument.identity()); },
         .open = true},
        {.header = "*OPC",
         .set = [](Call& call) { call.session.complete_operation(); },
         .query = when_complete},
        {.header = "*OPT",
         .query = [](Call& call) { call.reply.word(call.session.shared().instrument.options()); }},
        {.header = "*RCL",
         .parameters = memory,
         .set = [](Call& call) { call.session.shared().instrument.recall(call.session, place(call)); },
         .guarded = true},
        {.header = "*RST", .set = reset, .guarded = true},
        {.header = "*SAV",
         .parameters = memory,
         .set = [](Call& call) { call.session.shared().instrument.save(place(call)); },
         .guarded = true},
        {.header = "*SRE",
         .parameters = mask,
         .set = [](Call& call) { call.session.status().set_service_mask(byte(call)); },
         .query = [](Call& call) { call.reply.integer(call.session.status().service_mask()); }},
        {.header = "*STB",
         .query = [](Call& call) { call.reply.integer(call.session.status_byte()); },
         .open = true},
        {.header = "*TRG",
         .set = [](Call& call) { call.session.shared().instrument.trigger(call.session); },
         .guarded = true},
        {.header = "*TST",
         .query = [](Call& call) { call.reply.integer(call.session.shared().instrument.self_test()); }},
        {.header = "*WAI", .set = wait},
        {.header = "ABORt",
         .set = [](Call& call) { call.session.abort(); },
         .query = [](Call& call) { call.session.abort_and_answer(); },
         .urgent = true,
         .open = true},
    };
}

std::vector<Command> status_commands() {
    std::vector<Command> rows;
    add(rows, "STATus:OPERation", &StatusModel::operation);
    add(rows, "STATus:QUEStionable", &StatusModel::questionable);
    rows.push_back({.header = "STATus:PRESet", .set = preset});
    return rows;
}

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
