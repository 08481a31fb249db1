#include "daemon/commands/calibrate/response_source.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "daemon/manual/values.hpp"
#include "daemon/recording/replay.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/reduction/reduction.hpp"
#include "daemon/sandbox/confined.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/csv.hpp"

namespace shaker::commands {

namespace {

using calibration::ResponseLine;
using Json = nlohmann::json;

Json line_json(int run, const ResponseLine& line) {
    return {run, line.hz, line.log_gain.value, line.log_gain.sigma, line.lead_rad.value, line.lead_rad.sigma};
}

Json certificate(const std::filesystem::path& file) {
    const std::array<std::string, 5> names{"frequency_hz", "gain", "gain_error", "phase_deg",
                                           "phase_error_deg"};
    constexpr double rad = std::numbers::pi / 180;
    const footage::CsvColumns table = footage::read_csv(file, names);
    Json lines = Json::array();
    for (std::size_t i = 0; i < table.values[0].size(); ++i) {
        const auto at = [&](std::size_t column) { return table.values[column][i]; };
        for (const std::size_t column : {0, 1, 2, 4})
            if (!(at(column) > 0))
                throw InputError{
                    fmt::format("{}: {} is {}; must be above 0", table.where(i), names[column], at(column))};
        lines.push_back(line_json(0, {.run = 0,
                                      .hz = at(0),
                                      .log_gain = {std::log(at(1)), at(2) / at(1)},
                                      .lead_rad = {rad * at(3), rad * at(4)}}));
    }
    return {{"runs", {file.filename().string()}}, {"lines", lines}, {"notes", Json::array()}};
}

Json recorded_lines(const std::filesystem::path& name) {
    const recorded::RecordingReader file{name};
    recording::require_known_schema(file);
    const recorded::RecordingHeader& header = file.header();
    std::vector<std::string> ignored;
    const acquisition::Streams streams =
        recording::replayed_streams(file, header, recording::why_not_followed_again(file).empty(), ignored);
    Json out{{"sensor", header.accelerometer.name},
             {"gravity", header.accelerometer.gravity},
             {"runs", Json::array()},
             {"lines", Json::array()},
             {"notes", Json::array()}};
    const auto add = [&](const recording::MeasuredPart& part, const std::string& of) {
        std::string why = "no harmonic of the base stands out in accelerometer and cameras";
        std::vector<ResponseLine> lines;
        try {
            lines = reduction::response_lines(
                measurement_of(streams, header.frequency_hz, part.from_s, part.to_s));
        } catch (const InputError& error) {
            why = error.what();
        }
        const int run = static_cast<int>(out["runs"].size());
        for (const ResponseLine& line : lines) out["lines"].push_back(line_json(run, line));
        if (lines.empty())
            out["notes"].push_back(fmt::format("{}: {}", of, why));
        else
            out["runs"].push_back(of);
    };
    const auto finished = recording::read_finished(file);
    for (const recording::FinishedMeasurement& m : finished)
        add(m.part, fmt::format("{}, measurement {}", name.filename().string(), m.number));
    if (finished.empty()) add(recording::read_reduced_part(file), name.filename().string());
    return out;
}

std::vector<std::filesystem::path> files_of(const std::vector<std::filesystem::path>& from) {
    std::vector<std::filesystem::path> files;
    for (const std::filesystem::path& place : from) {
        if (!std::filesystem::is_directory(place)) {
            files.push_back(place);
            continue;
        }
        std::vector<std::filesystem::path> found;
        for (const auto& entry : std::filesystem::directory_iterator{place})
            if (entry.path().extension() == ".nxs" && entry.path().filename() != "campaign.nxs")
                found.push_back(entry.path());
        if (found.empty()) throw InputError{place.string() + ": the folder has no recordings (*.nxs)"};
        std::ranges::sort(found);
        files.insert(files.end(), found.begin(), found.end());
    }
    return files;
}

void append(const Json& answer, const std::filesystem::path& file, ResponseSource& out) {
    const int before = static_cast<int>(out.runs.size());
    if (answer.contains("sensor")) {
        const std::string sensor = answer.at("sensor");
        if (!out.sensor.empty() && sensor != out.sensor)
            throw InputError{fmt::format("{}: is of \"{}\"; the files before are of \"{}\"", file.string(),
                                         sensor, out.sensor)};
        out.sensor = sensor;
        out.gravity = answer.at("gravity");
    }
    for (const Json& run : answer.at("runs")) out.runs.push_back(run);
    for (const Json& note : answer.at("notes")) out.notes.push_back(note);
    for (const Json& line : answer.at("lines")) {
        const int run = line.at(0);
        if (run < 0 || before + run >= static_cast<int>(out.runs.size()))
            throw InputError{file.string() + ": its reader numbers the runs wrongly"};
        out.lines.push_back({before + run, line.at(1), {line.at(2), line.at(3)}, {line.at(4), line.at(5)}});
    }
}

}  // namespace

ResponseSource response_source(const std::vector<std::filesystem::path>& from) {
    ResponseSource out;
    const std::vector<std::filesystem::path> files = files_of(from);
    const auto is_certificate = [](const std::filesystem::path& file) { return file.extension() == ".csv"; };
    if (const auto found = std::ranges::find_if(files, is_certificate);
        files.size() > 1 && found != files.end())
        throw InputError{found->string() + ": a certificate has a gain of its own; give it alone"};
    for (const std::filesystem::path& file : files) {
        const auto read = is_certificate(file) ? certificate : recorded_lines;
        const sandbox::Answer answer = sandbox::ask_confined(file.string(), sandbox::confinement_for(file),
                                                             [&] { return read(file).dump(); });
        if (answer.status != manual::exit_ok) throw InputError{file.string() + ": was not read"};
        try {
            append(Json::parse(answer.text), file, out);
        } catch (const Json::exception&) {
            throw InputError{file.string() + ": its reader answers wrongly"};
        }
    }
    return out;
}

}  // namespace shaker::commands
