// Commands that are made from the rows of the table of orders.
#include <string>
#include <utility>

#include "daemon/orders/values.hpp"
#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "daemon/service/made_order.hpp"

namespace shaker::instrument {

namespace {

using orders::Field, orders::Kind;

scpi::Parameter parameter_of(const Field& field) {
    constexpr std::size_t longest_name = 64;
    switch (field.kind) {
        case Kind::quantity:
            return scpi::number("", field.allowed.min, field.allowed.max);
        case Kind::whole:
            return scpi::integer(field.allowed.min, field.allowed.max);
        case Kind::flag:
            return scpi::boolean();
        default:
            return scpi::string(field.key == "text" ? service::Remark::longest : longest_name);
    }
}

orders::Values values_of(const orders::Row& row, std::span<const scpi::Argument> arguments) {
    orders::Values values{row};
    std::size_t next = 0;
    for (const Field& field : row.fields) {
        if (!field.scpi) continue;
        const scpi::Argument& a = arguments[next++];
        if (!a.given) continue;
        if (field.kind == Kind::flag)
            values.add_flag(field.key, a.on);
        else if (field.kind == Kind::quantity || field.kind == Kind::whole)
            values.add_number(field.key, a.number);
        else
            values.add_text(field.key, std::string{a.text});
    }
    return values;
}

}  // namespace

scpi::Command command_of(BenchInstrument& bench, std::string_view order, scpi::Handler query,
                         scpi::Placeholder without) {
    const orders::Row& row = orders::row(order);
    scpi::Command command{.header = std::string{row.scpi},
                          .set =
                              [&bench, &row](scpi::Call& call) {
                                  bench.order(call.session, service::made(values_of(row, call.arguments),
                                                                          bench.pending_orders().settings()));
                              },
                          .query = std::move(query),
                          .without = without,
                          .guarded = true};
    for (const Field& field : row.fields) {
        if (!field.scpi) continue;
        const bool needed = field.needed || command.parameters.empty();
        command.parameters.push_back(needed ? parameter_of(field) : scpi::optional(parameter_of(field)));
    }
    return command;
}

}  // namespace shaker::instrument
