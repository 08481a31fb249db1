// Campaigns: the points of a plan, one after the other.
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <array>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "daemon/service/made_order.hpp"

namespace shaker::instrument {

using scpi::Command;

namespace {

/// CAMPaign:SCAN PHI|GAMMa, from, to, steps [, periods [, repeats]], in SI units.
Command scan_command(BenchInstrument& bench) {
    const auto whole = [](std::string_view key) {
        const auto fields = orders::row("campaign").fields;
        const Range allowed = std::ranges::find(fields, key, &orders::Field::key)->allowed;
        return scpi::integer(allowed.min, allowed.max);
    };
    return {
        .header = "CAMPaign:SCAN",
        .parameters = {scpi::choice("PHI|GAMMa"), scpi::number("", -1e6, 1e6), scpi::number("", -1e6, 1e6),
                       whole("steps"), scpi::optional(whole("periods")), scpi::optional(whole("repeats"))},
        .set =
            [&bench](scpi::Call& call) {
                orders::Values values{orders::row("campaign")};
                values.add_text("scan", call.arguments[0].word == 0 ? "phi" : "gamma");
                constexpr std::array keys{"from", "to", "steps", "periods", "repeats"};
                for (std::size_t i = 0; i < keys.size(); ++i)
                    if (const scpi::Argument& a = call.arguments[i + 1]; a.given)
                        values.add_number(keys.at(i), a.number);
                bench.order(call.session, service::made(values, bench.pending_orders().settings()));
            },
        .guarded = true};
}

}  // namespace

std::vector<Command> campaign_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    rows.push_back(command_of(bench, "campaign"));
    rows.push_back(scan_command(bench));
    rows.push_back(command_of(
        bench, "campaign/check",
        [&bench](scpi::Call& call) {
            const auto state = bench.state();
            const auto& check = state->plan_check;
            std::string words = check && !check->under_way ? check->summary : "";
            if (check)
                for (const std::string& misfit : check->misfits) words += "; " + misfit;
            call.reply.string(words);
        },
        scpi::empty_string));
    for (const std::string_view word : campaign::word_names)
        rows.push_back(command_of(bench, fmt::format("campaign/{}", word)));
    rows.push_back(asks(bench, "CAMPaign:CATalog",
                        [](const auto& s) { return fmt::format("{}", fmt::join(s.plans, ",")); }));
    rows.push_back(
        asks(bench, "CAMPaign:STATe", [](const auto& s) { return s.campaign ? s.campaign->doing : "none"; }));
    rows.push_back(
        asks(bench, "CAMPaign:FOLDer", [](const auto& s) { return s.campaign ? s.campaign->folder : ""; }));
    return rows;
}

}  // namespace shaker::instrument
