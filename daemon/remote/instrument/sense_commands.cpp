#include <spdlog/fmt/fmt.h>

#include <string>

#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/data/error.hpp"
#include "daemon/remote/scpi/data/reply.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

constexpr std::size_t before_cameras = 2;  // DAC and accelerometer, before the cameras in the reports

template <class Answer>
Command camera_row(BenchInstrument& bench, const char* what, Answer answer,
                   scpi::Placeholder without = scpi::nans<1>) {
    return {.header = std::string{"SENSe:CAMera<1..4>:"} + what,
            .query =
                [&bench, answer](scpi::Call& call) {
                    const auto state = bench.state();
                    const auto& views = state->facts->views;
                    if (call.suffixes[0] > views.size())
                        throw scpi::Error{
                            scpi::Code::hardware_missing,
                            fmt::format("camera {}: there are {}", call.suffixes[0], views.size())};
                    answer(*state, call.suffixes[0] - 1U, call.reply);
                },
            .without = without};
}

void numbers(scpi::Reply& reply, const std::array<double, 3>& values) {
    for (const double x : values) reply.number(x);
}

}  // namespace

std::vector<Command> sense_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    rows.push_back({.header = "SENSe:ACCeleration:AXIS",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto s = bench.state();
                            numbers(call.reply,
                                    s->response ? s->response->axis : s->facts->accelerometer.shaker_axis);
                        },
                    .without = scpi::nans<3>});
    rows.push_back(camera_row(
        bench, "FRAMes",
        [](const service::BenchState& s, std::size_t k, scpi::Reply& r) {
            const DeviceCounts& c = s.devices.at(before_cameras + k).counts;
            r.integer(static_cast<std::int64_t>(c.taken));
            r.integer(static_cast<std::int64_t>(c.lost));
        },
        scpi::nans<2>));
    rows.push_back(
        camera_row(bench, "QUALity", [](const service::BenchState& s, std::size_t k, scpi::Reply& r) {
            const service::PictureState& p = s.pictures_now.at(k);
            if (p.fixes.empty())
                throw scpi::Error{scpi::Code::stale_data, "no picture has been received yet"};
            for (const tracking::Fix& fix : p.fixes) r.integer(static_cast<int>(fix.state));
        }));
    rows.push_back({.header = "STReam:ADDRess",
                    .query = [&bench](scpi::Call& call) { call.reply.string(bench.streams); },
                    .without = scpi::empty_string});
    return rows;
}

}  // namespace shaker::instrument
