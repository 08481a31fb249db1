#include <array>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

void keep_pictures(BenchInstrument& bench, scpi::Call& call) {
    service::Record record = bench.pending_orders().settings().record;
    record.pictures = static_cast<recorded::KeptPictures>(call.arguments[0].word);
    bench.order(call.session, std::move(record));
}

}  // namespace

std::vector<Command> record_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    rows.push_back(
        command_of(bench, "record", one([&bench] { return bench.pending_orders().settings().record.on; })));
    rows.push_back(command_of(bench, "remark"));
    rows.push_back(asks(bench, "RECord:NAME", [](const auto& s) { return s.recording.name; }));
    rows.push_back({.header = "RECord:RAW:CAMera",
                    .parameters = {scpi::choice("OFF|FIRSt|REGion|FULL")},
                    .set = [&bench](scpi::Call& call) { keep_pictures(bench, call); },
                    .query =
                        [&bench](scpi::Call& call) {
                            constexpr std::array words{"OFF", "FIRS", "REG", "FULL"};
                            call.reply.word(words.at(
                                static_cast<std::size_t>(bench.pending_orders().settings().record.pictures)));
                        },
                    .guarded = true});
    return rows;
}

}  // namespace shaker::instrument
