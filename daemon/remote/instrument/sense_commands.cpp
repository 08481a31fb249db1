#include <spdlog/fmt/fmt.h>

#include <string>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

constexpr std::size_t before_cameras = 2;  // DAC and accelerometer, before the cameras in the reports

const View& camera_of(const service::BenchState& state, std::size_t number) {
    const auto& views = state.facts->views;
    if (number <= views.size()) return views[number - 1];
    throw scpi::Error{scpi::Code::hardware_missing,
                      fmt::format("camera {}: there are {}", number, views.size())};
}

template <class Answer>
Command camera_row(BenchInstrument& bench, const char* what, Answer answer,
                   scpi::Placeholder without = scpi::nans<1>) {
    return {.header = std::string{"SENSe:CAMera<1..4>:"} + what,
            .query =
                [&bench, answer](scpi::Call& call) {
                    const auto state = bench.state();
                    static_cast<void>(camera_of(*state, call.suffixes[0]));
                    answer(*state, call.suffixes[0] - 1U, call.reply);
                },
            .without = without};
}

void move_target(BenchInstrument& bench, scpi::Call& call) {
    acquisition::MovedTarget moved{
        camera_of(*bench.state(), call.suffixes[0]).camera, std::string{call.arguments[0].text}, {}};
    for (std::size_t i = 0; i < 4; ++i) moved.roi_px[i] = call.arguments[i + 1].number;
    bench.order(call.session, service::MoveTargets{{std::move(moved)}});
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
            if (k >= s.pictures_now.size() || s.pictures_now[k].fixes.empty())
                throw scpi::Error{scpi::Code::stale_data, "no picture has been received yet"};
            for (const tracking::Fix& fix : s.pictures_now[k].fixes) r.integer(static_cast<int>(fix.state));
        }));
    rows.push_back(camera_row(
        bench, "TARGet:CATalog",
        [](const service::BenchState& s, std::size_t k, scpi::Reply& r) {
            for (const Target& t : s.facts->views[k].targets) {
                r.string(t.name);
                for (const int x : t.roi_px) r.integer(x);
            }
        },
        scpi::empty_string));
    const auto px = scpi::number("", 0, 65536);
    rows.push_back({.header = "SENSe:CAMera<1..4>:TARGet:REGion",
                    .parameters = {scpi::string(64), px, px, px, px},
                    .set = [&bench](scpi::Call& call) { move_target(bench, call); },
                    .guarded = true});
    rows.push_back({.header = "STReam:ADDRess",
                    .query = [&bench](scpi::Call& call) { call.reply.string(bench.streams); },
                    .without = scpi::empty_string});
    return rows;
}

}  // namespace shaker::instrument
