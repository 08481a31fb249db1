#include "tests/support/remote/scpi_client.hpp"

#include <utility>

#include "daemon/remote/scpi/standard_commands.hpp"
#include "drivers/errors.hpp"

namespace shaker::test {
namespace {

using namespace scpi;

/// Throws the exception that `kind` names, as a handler would.
void fail(const std::string& kind) {
    if (kind == "input") throw InputError{"scene.toml: no such key"};
    if (kind == "device") throw DeviceError{"hw:1: No such device"};
    if (kind == "trip") throw TripError{"accel Z 61.2 m/s2 > 50"};
    if (kind == "unknown") throw std::logic_error{"this should not happen"};
    throw scpi::Error{static_cast<scpi::Code>(std::stoi(kind)), "what was wrong"};
}

std::vector<Command> source_rows(ScpiBench& bench) {
    auto& told = bench.instrument.told;
    return {
        {.header = "[SOURce:]FREQuency[:FIXed]",
         .parameters = {number("HZ", 1, 200, 20)},
         .set = [&](scpi::Call& call) { bench.frequency = call.arguments[0].number; },
         .query = [&](scpi::Call& call) { call.reply.number(bench.frequency); },
         .guarded = true},
        {.header = "[SOURce:]ACCeleration[:LEVel]",
         .parameters = {number("M/S2", 0, 60)},
         .set = [&](scpi::Call& call) { bench.acceleration = call.arguments[0].number; },
         .query = [&](scpi::Call& call) { call.reply.number(bench.acceleration); },
         .guarded = true},
        {.header = "[SOURce:]BIHarmonic:RHO",
         .parameters = {number("1", 0, 1, 0.5)},
         .set = [&](scpi::Call& call) { told.push_back("rho " + std::to_string(call.arguments[0].number)); }},
        {.header = "[SOURce:]BIHarmonic:PHASe",
         .parameters = {number("RAD", -10, 10, 0)},
         .set =
             [&](scpi::Call& call) { told.push_back("phase " + std::to_string(call.arguments[0].number)); }},
        {.header = "[SOURce:]HARMonic<1..16>:AMPLitude",
         .parameters = {number("1", 0, 1, 0)},
         .set =
             [&](scpi::Call& call) { bench.amplitudes.at(call.suffixes[0] - 1U) = call.arguments[0].number; },
         .query = [&](scpi::Call& call) { call.reply.number(bench.amplitudes.at(call.suffixes[0] - 1U)); }},
        {.header = "[SOURce:]HARMonic<1..16>:PHASe",
         .parameters = {number("RAD", -10, 10, 0)},
         .set =
             [&](scpi::Call& call) { told.push_back("harmonic phase " + std::to_string(call.suffixes[0])); }},
        {.header = "[SOURce:]FUNCtion[:SHAPe]",
         .parameters = {choice("SINusoid|BIHarmonic|NONE")},
         .set = [&](scpi::Call& call) { told.push_back("shape " + std::to_string(call.arguments[0].word)); }},
        {.header = "[SOURce:]ARBitrary:DATA",
         .parameters = {block(40000)},
         .set = [&](scpi::Call& call) { bench.wave = call.arguments[0].text; },
         .query = [&](scpi::Call& call) { call.reply.block(bench.wave); }},
        {.header = "[SOURce:]APPLy:BIHarmonic",
         .parameters = {number("HZ", 1, 200), number("M/S2", 0, 60), number("1", 0, 1),
                        optional(number("RAD", -10, 10, 0.25))},
         .set =
             [&](scpi::Call& call) {
                 std::string text = "apply";
                 for (const Argument& value : call.arguments)
                     text.append(" ").append(std::to_string(value.number));
                 told.push_back(text);
             }},
    };
}

std::vector<Command> other_rows(ScpiBench& bench) {
    auto& told = bench.instrument.told;
    return {
        {.header = "OUTPut[:STATe]",
         .parameters = {boolean()},
         .set = [&](scpi::Call& call) { told.emplace_back(call.arguments[0].on ? "on" : "off"); },
         .guarded = true},
        {.header = "INITiate[:IMMediate]", .set = [&](scpi::Call&) { bench.instrument.busy = true; }},
        {.header = "SENSe<1..2>:CAMera<1..4>:EXPosure",
         .parameters = {number("S", 0, 1)},
         .set =
             [&](scpi::Call& call) {
                 told.push_back("exposure " + std::to_string(call.suffixes[0]) + " " +
                                std::to_string(call.suffixes[1]) + " " +
                                std::to_string(call.arguments[0].number));
             }},
        {.header = "SENSe<1..2>:CAMera<1..4>:SCALe",
         .parameters = {number("MM/PX", 0, 1)},
         .set =
             [&](scpi::Call& call) { told.push_back("scale " + std::to_string(call.arguments[0].number)); }},
        {.header = "AVERage:PERiods",
         .parameters = {integer(1, 100, 40)},
         .set =
             [&](scpi::Call& call) {
                 told.push_back("periods " + std::to_string(call.arguments[0].number));
             }},
        {.header = "AVERage:SETTle",
         .parameters = {or_word("AUTO", integer(1, 100, 20))},
         .set =
             [&](scpi::Call& call) { told.push_back("settle " + std::to_string(call.arguments[0].word)); }},
        {.header = "LIMit:ACCeleration:WARN",
         .parameters = {number("M/S2", 0, 100)},
         .set = [](scpi::Call&) {}},
        {.header = "LIMit:ACCeleration:ABORt",
         .parameters = {number("M/S2", 0, 100)},
         .set = [&](scpi::Call&) { told.emplace_back("abort level"); }},
        {.header = "LIMit:WALKer:MINimum",
         .parameters = {number("MM", -100, 100)},
         .set =
             [&](scpi::Call& call) { told.push_back("edge " + std::to_string(call.arguments[0].number)); }},
        {.header = "RECord:NOTE",
         .parameters = {string(20)},
         .set = [&](scpi::Call& call) { bench.note = call.arguments[0].text; },
         .query = [&](scpi::Call& call) { call.reply.string(bench.note); }},
        {.header = "FETCh:DRIFt",
         .query =
             [](scpi::Call& call) {
                 call.reply.numbers(std::array{36.5e-3, std::nan(""), HUGE_VAL, -HUGE_VAL});
             }},
        {.header = "MMEMory:DATA",
         .query =
             [](scpi::Call& call) {
                 call.reply.block(std::string(call.arguments[0].text.size() * 100000, 'x'));
             },
         .query_parameters = {string()}},
        {.header = "DIAGnostic:FAULt",
         .parameters = {string()},
         .set = [](scpi::Call& call) { fail(std::string{call.arguments[0].text}); },
         .query =
             [](scpi::Call& call) {
                 call.reply.number(1);
                 fail(std::string{call.arguments[0].text});
             },
         .query_parameters = {string()}},
        {.header = "DIAGnostic:SILent", .query = [](scpi::Call&) {}},
    };
}

std::vector<Command> table(ScpiBench& bench) {
    std::vector<Command> rows = source_rows(bench);
    for (Command& row : other_rows(bench)) rows.push_back(std::move(row));
    return with_standard_commands(std::move(rows));
}

}  // namespace

ScpiBench::ScpiBench() : tree{table(*this)} {}

std::string ScpiClient::read() {
    std::string text{session.output()};
    session.sent(text.size());
    return text;
}

}  // namespace shaker::test
