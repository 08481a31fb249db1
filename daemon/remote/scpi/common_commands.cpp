#include <utility>

#include "daemon/remote/scpi/data/reply.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "daemon/remote/scpi/standard_commands.hpp"

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

}  // namespace shaker::scpi
