#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "daemon/remote/bench/commands.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker {

namespace {

using scpi::Call;
using scpi::Code;
using scpi::Command;
using scpi::Error;

constexpr std::uintmax_t largest_file =
    scpi::Session::output_limit - 64;      // bytes that MMEMory:DATA? answers with
constexpr std::size_t before_cameras = 2;  // DAC and accelerometer, in the reports

template <class Tell>
Command accelerometer_row(BenchInstrument& bench, const char* what, Tell tell) {
    return {.header = std::string{"SENSe:ACCeleration:"} + what,
            .query = [&bench, tell](Call& call) { tell(bench.state()->facts->accelerometer, call.reply); }};
}

template <class Tell>
Command camera_row(BenchInstrument& bench, const char* what, Tell tell) {
    return {.header = std::string{"SENSe:CAMera<1..4>:"} + what, .query = [&bench, tell](Call& call) {
                const auto state = bench.state();
                const auto& views = state->facts->views;
                if (call.suffixes[0] > views.size())
                    throw Error{Code::header_suffix_out_of_range,
                                fmt::format("camera {}: there are {}", call.suffixes[0], views.size())};
                tell(*state, call.suffixes[0] - 1U, call.reply);
            }};
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

void data(const BenchInstrument& bench, Call& call) {
    const std::string name{call.arguments[0].text};
    const std::filesystem::path file = recordings(bench) / name;
    if (std::filesystem::path{name}.filename() != name || file.extension() != ".nxs" ||
        !std::filesystem::is_regular_file(file))
        throw Error{Code::file_not_found, fmt::format("\"{}\" is none of MMEMory:CATalog?", name)};
    if (const auto size = std::filesystem::file_size(file); size > largest_file)
        throw Error{Code::too_much_data,
                    fmt::format("\"{}\" has {} bytes; {} at most are sent", name, size, largest_file)};
    std::ifstream in{file, std::ios::binary};
    call.reply.block(std::string{std::istreambuf_iterator<char>{in}, {}});
}

}  // namespace

std::vector<Command> sense_commands(BenchInstrument& bench) {
    using Info = AccelerometerInfo;
    using scpi::Reply;
    std::vector<Command> rows;
    rows.push_back(accelerometer_row(bench, "NAME", [](const Info& a, Reply& r) { r.string(a.name); }));
    rows.push_back(accelerometer_row(bench, "SRATe", [](const Info& a, Reply& r) { r.number(a.rate_hz); }));
    rows.push_back(
        accelerometer_row(bench, "RANGe", [](const Info& a, Reply& r) { r.number(a.range_mps2); }));
    rows.push_back(accelerometer_row(bench, "SENSitivity",
                                     [](const Info& a, Reply& r) { numbers(r, a.mps2_per_count); }));
    rows.push_back(
        accelerometer_row(bench, "OFFSet", [](const Info& a, Reply& r) { numbers(r, a.offset_counts); }));
    rows.push_back({.header = "SENSe:ACCeleration:AXIS", .query = [&bench](Call& call) {
                        const auto s = bench.state();
                        numbers(call.reply,
                                s->response ? s->response->axis : s->facts->accelerometer.shaker_axis);
                    }});
    rows.push_back(camera_row(bench, "NAME", [](const BenchState& s, std::size_t k, Reply& r) {
        r.string(s.facts->views[k].camera);
    }));
    rows.push_back(camera_row(bench, "FRATe", [](const BenchState& s, std::size_t k, Reply& r) {
        r.number(s.facts->views[k].frame_rate_hz);
    }));
    rows.push_back(camera_row(bench, "EXPosure", [](const BenchState& s, std::size_t k, Reply& r) {
        r.number(s.facts->views[k].exposure_s);
    }));
    rows.push_back(camera_row(bench, "SCALe", [](const BenchState& s, std::size_t k, Reply& r) {
        r.number(s.facts->views[k].mm_per_px);
    }));
    rows.push_back(camera_row(bench, "FRAMes", [](const BenchState& s, std::size_t k, Reply& r) {
        const DeviceCounts& c = s.devices.at(before_cameras + k).counts;
        r.integer(static_cast<std::int64_t>(c.taken));
        r.integer(static_cast<std::int64_t>(c.lost));
    }));
    rows.push_back(camera_row(bench, "QUALity", [](const BenchState& s, std::size_t k, Reply& r) {
        const PictureState& p = s.pictures_now.at(k);
        if (p.fixes.empty()) throw Error{Code::stale_data, "no picture has come yet"};
        for (const Fix& fix : p.fixes) r.integer(static_cast<int>(fix.state));
    }));
    rows.push_back(
        {.header = "STReam:ADDRess", .query = [&bench](Call& call) { call.reply.string(bench.streams); }});
    rows.push_back(
        {.header = "MMEMory:CATalog", .query = [&bench](Call& call) { catalog(bench, call.reply); }});
    rows.push_back({.header = "MMEMory:DATA",
                    .query = [&bench](Call& call) { data(bench, call); },
                    .query_parameters = {scpi::string()}});
    return rows;
}

}  // namespace shaker
