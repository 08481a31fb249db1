#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/data/error.hpp"
#include "daemon/remote/scpi/data/reply.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

constexpr std::uintmax_t largest_file =
    scpi::Session::output_limit - 64;      // bytes, largest answer of MMEMory:DATA?
constexpr std::size_t before_cameras = 2;  // DAC and accelerometer, before the cameras in the reports

template <class Answer>
Command accelerometer_row(BenchInstrument& bench, const char* what, Answer answer,
                          scpi::Placeholder without = scpi::nans<1>) {
    return {.header = std::string{"SENSe:ACCeleration:"} + what,
            .query = [&bench,
                      answer](scpi::Call& call) { answer(bench.state()->facts->accelerometer, call.reply); },
            .without = without};
}

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

std::filesystem::path recordings(const BenchInstrument& bench) { return bench.state()->facts->recordings; }

void catalog(const BenchInstrument& bench, scpi::Reply& reply) {
    std::vector<std::filesystem::directory_entry> files;
    std::error_code failed;
    for (const auto& entry : std::filesystem::directory_iterator{recordings(bench), failed})
        if (entry.path().extension() == ".nxs") files.push_back(entry);
    std::ranges::sort(files);
    if (files.empty()) return reply.string("");
    for (const auto& entry : files) {
        reply.string(entry.path().filename().string());
        reply.integer(static_cast<std::int64_t>(entry.file_size(failed)));
    }
}

void data(const BenchInstrument& bench, scpi::Call& call) {
    const std::string name{call.arguments[0].text};
    const std::filesystem::path file = recordings(bench) / name;
    if (std::filesystem::path{name}.filename() != name || file.extension() != ".nxs" ||
        !std::filesystem::is_regular_file(file))
        throw scpi::Error{scpi::Code::file_not_found, fmt::format("\"{}\" is not in MMEMory:CATalog?", name)};
    if (const auto size = std::filesystem::file_size(file); size > largest_file)
        throw scpi::Error{scpi::Code::too_much_data,
                          fmt::format("\"{}\" has {} bytes; limit {}", name, size, largest_file)};
    std::ifstream in{file, std::ios::binary};
    call.reply.block(std::string{std::istreambuf_iterator<char>{in}, {}});
}

}  // namespace

std::vector<Command> sense_commands(BenchInstrument& bench) {
    using Info = AccelerometerInfo;
    using scpi::Reply;
    std::vector<Command> rows;
    rows.push_back(accelerometer_row(
        bench, "NAME", [](const Info& a, scpi::Reply& r) { r.string(a.name); }, scpi::empty_string));
    rows.push_back(
        accelerometer_row(bench, "SRATe", [](const Info& a, scpi::Reply& r) { r.number(a.rate_hz); }));
    rows.push_back(
        accelerometer_row(bench, "RANGe", [](const Info& a, scpi::Reply& r) { r.number(a.range_mps2); }));
    rows.push_back(accelerometer_row(
        bench, "SENSitivity", [](const Info& a, scpi::Reply& r) { numbers(r, a.mps2_per_count); },
        scpi::nans<3>));
    rows.push_back(accelerometer_row(
        bench, "OFFSet", [](const Info& a, scpi::Reply& r) { numbers(r, a.offset_counts); }, scpi::nans<3>));
    rows.push_back({.header = "SENSe:ACCeleration:AXIS",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto s = bench.state();
                            numbers(call.reply,
                                    s->response ? s->response->axis : s->facts->accelerometer.shaker_axis);
                        },
                    .without = scpi::nans<3>});
    rows.push_back(camera_row(
        bench, "NAME",
        [](const service::BenchState& s, std::size_t k, scpi::Reply& r) {
            r.string(s.facts->views[k].camera);
        },
        scpi::empty_string));
    rows.push_back(
        camera_row(bench, "FRATe", [](const service::BenchState& s, std::size_t k, scpi::Reply& r) {
            r.number(s.facts->views[k].frame_rate_hz);
        }));
    rows.push_back(
        camera_row(bench, "EXPosure", [](const service::BenchState& s, std::size_t k, scpi::Reply& r) {
            r.number(s.facts->views[k].exposure_s);
        }));
    rows.push_back(
        camera_row(bench, "SCALe", [](const service::BenchState& s, std::size_t k, scpi::Reply& r) {
            r.number(s.facts->views[k].mm_per_px);
        }));
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
    rows.push_back({.header = "MMEMory:CATalog",
                    .query = [&bench](scpi::Call& call) { catalog(bench, call.reply); },
                    .without = scpi::empty_string});
    rows.push_back({.header = "MMEMory:DATA",
                    .query = [&bench](scpi::Call& call) { data(bench, call); },
                    .query_parameters = {scpi::string()},
                    .without = scpi::empty_block});
    return rows;
}

}  // namespace shaker::instrument
