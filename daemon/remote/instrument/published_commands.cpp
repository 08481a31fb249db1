#include <spdlog/fmt/fmt.h>

#include <variant>

#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/data/error.hpp"
#include "daemon/service/published.hpp"

namespace shaker::instrument {

namespace {

void reply(const service::Published& row, const service::BenchState& state, scpi::Reply& to) {
    const auto give = [&]<class T>(T value) {
        if constexpr (std::is_same_v<T, bool>)
            to.boolean(value);
        else if constexpr (std::is_same_v<T, std::uint64_t>)
            to.integer(static_cast<std::int64_t>(value));
        else if constexpr (std::is_same_v<T, double>)
            to.number(value);
        else
            throw scpi::Error{scpi::Code::stale_data, fmt::format("not known yet: {}", row.help)};
    };
    std::visit(give, row.value(state));
}

}  // namespace

std::vector<scpi::Command> published_commands(BenchInstrument& bench) {
    std::vector<scpi::Command> rows;
    for (const service::Published& row : service::published_quantities())
        if (row.header != nullptr)
            rows.push_back({.header = row.header, .query = [&bench, &row](scpi::Call& call) {
                                reply(row, *bench.state(), call.reply);
                            }});
    return rows;
}

}  // namespace shaker::instrument
