#include <string>

#include "daemon/remote/scpi/session.hpp"
#include "daemon/remote/scpi/standard_commands.hpp"

namespace shaker::scpi {
namespace {

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

}  // namespace

std::vector<Command> status_commands() {
    std::vector<Command> rows;
    add(rows, "STATus:OPERation", &StatusModel::operation);
    add(rows, "STATus:QUEStionable", &StatusModel::questionable);
    rows.push_back({.header = "STATus:PRESet", .set = preset});
    return rows;
}

}  // namespace shaker::scpi
