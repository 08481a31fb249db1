// Campaigns: the points of a plan, one after the other.
#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker::instrument {

using scpi::Command;

std::vector<Command> campaign_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    rows.push_back({.header = "CAMPaign:STARt",
                    .parameters = {scpi::string(64)},
                    .set =
                        [&bench](scpi::Call& call) {
                            bench.order(call.session,
                                        service::MeasurePlan{std::string{call.arguments[0].text}});
                        },
                    .guarded = true});
    rows.push_back({.header = "CAMPaign:CHECk",
                    .parameters = {scpi::string(64)},
                    .set =
                        [&bench](scpi::Call& call) {
                            bench.order(call.session,
                                        service::CheckPlan{std::string{call.arguments[0].text}});
                        },
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto& check = bench.state()->plan_check;
                            std::string words = check && !check->under_way ? check->summary : "";
                            if (check)
                                for (const std::string& misfit : check->misfits) words += "; " + misfit;
                            call.reply.string(words);
                        },
                    .without = scpi::empty_string,
                    .guarded = true});
    constexpr std::array headers{"CAMPaign:PAUSe", "CAMPaign:RESume", "CAMPaign:SKIP", "CAMPaign:REPeat",
                                 "CAMPaign:STOP"};
    static_assert(headers.size() == campaign::word_names.size());
    for (std::size_t i = 0; i < headers.size(); ++i)
        rows.push_back(
            {.header = headers.at(i),
             .set = [&bench, word = static_cast<campaign::Word>(i)](
                        scpi::Call& call) { bench.order(call.session, service::TellCampaign{word}); },
             .guarded = true});
    rows.push_back({.header = "CAMPaign:CATalog",
                    .query =
                        [&bench](scpi::Call& call) {
                            std::string names;
                            for (const std::string& name : bench.state()->plans)
                                names += (names.empty() ? "" : ",") + name;
                            call.reply.string(names);
                        },
                    .without = scpi::empty_string});
    rows.push_back({.header = "CAMPaign:STATe",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto s = bench.state();
                            call.reply.string(s->campaign ? s->campaign->doing : "none");
                        },
                    .without = scpi::empty_string});
    rows.push_back({.header = "CAMPaign:FOLDer",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto s = bench.state();
                            call.reply.string(s->campaign ? s->campaign->folder : "");
                        },
                    .without = scpi::empty_string});
    return rows;
}

}  // namespace shaker::instrument
