#include "daemon/catalogue/row_text.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "drivers/text/printable.hpp"

namespace shaker::catalogue {

namespace {

using calibration::Estimate;
using nlohmann::json;

constexpr std::size_t longest_text = 500;  // bytes

std::string key_of(const ListedQuantity& l) { return std::string{l.quantity.name}.append(l.quantity.suffix); }

Estimate estimate_from(const json& row, const std::string& key) {
    const auto found = row.find(key);
    if (found == row.end() || !found->is_object()) return {};
    return {number_from(*found, "value"), number_from(*found, "sigma")};
}

json overtones_json(const Drive& drive) {
    json all = json::array();
    for (std::size_t i = 0; i < drive.overtones.size(); ++i)
        if (const std::complex<double> share = drive.overtones[i]; share != 0.0)
            all.push_back({{"n", i + 3}, {"share", std::abs(share)}, {"phase_rad", std::arg(share)}});
    return all;
}

std::optional<Drive> asked_from(const json& row) {
    const auto found = row.find("asked");
    if (found == row.end() || !found->is_object()) return std::nullopt;
    Drive drive;
    drive.frequency = number_from(*found, "frequency_hz");
    drive.gamma = number_from(*found, "gamma_mps2");
    drive.rho = number_from(*found, "rho");
    drive.phi = number_from(*found, "phi_rad");
    const auto overtones = found->find("overtones");
    if (overtones == found->end() || !overtones->is_array()) return drive;
    for (const json& o : *overtones) {
        const double n = number_from(o, "n"), share = number_from(o, "share");
        const double phase = number_from(o, "phase_rad");
        if (!(n >= 3 && n <= static_cast<double>(most_driven)) || !(share >= 0) || !std::isfinite(phase))
            continue;
        drive.overtones.at(static_cast<std::size_t>(n) - 3) = std::polar(share, phase);
    }
    return drive;
}

std::string number_text(double x) { return std::isfinite(x) ? fmt::format("{:.17g}", x) : ""; }

std::string quoted(const std::string& text) {
    std::string all = "\"";
    for (const char c : text) all += c == '"' ? std::string{"\"\""} : std::string{c};
    return all + '"';
}

std::string overtones_text(const Drive& drive) {
    std::string all;
    for (const json& o : overtones_json(drive))
        all += fmt::format("{}{}: {} at {} rad", all.empty() ? "" : "; ", o["n"].get<int>(),
                           number_text(o["share"]), number_text(o["phase_rad"]));
    return all;
}

using nlohmann::json;

std::string time_of(std::filesystem::file_time_type changed) {
    const auto time = std::chrono::system_clock::to_time_t(
        std::chrono::time_point_cast<std::chrono::system_clock::duration>(
            std::chrono::file_clock::to_sys(changed)));
    return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(time));
}

json or_null(const std::string& text) { return text.empty() ? json(nullptr) : json(text); }

json json_of(const ListedRecording& r) {
    json set_points = json::array();
    for (const Drive& drive : r.set_points) set_points.push_back(asked_json(drive));
    json all{{"name", r.name},
             {"bytes", r.bytes},
             {"changed", time_of(r.changed)},
             {"trouble", or_null(r.trouble)},
             {"set_points", set_points},
             {"replay", or_null(r.replay.verdict)},
             {"replay_text", or_null(r.replay.text)},
             {"remarks", json::array()}};
    for (const char* key : {"title", "kind", "started", "pictures", "outcome", "measurements"})
        all[key] = nullptr;
    if (!r.summary) return all;
    const RecordingSummary& s = *r.summary;
    all["title"] = s.title;
    all["kind"] = s.kind;
    all["started"] = or_null(s.started);
    all["pictures"] = s.pictures;
    all["outcome"] = s.outcome;
    all["measurements"] = s.measurements;
    all["remarks"] = s.remarks;
    return all;
}

json json_of(const ListedCampaign& c) {
    return {{"name", c.name},
            {"bytes", c.bytes},
            {"changed", time_of(c.changed)},
            {"recordings", c.recordings},
            {"complete", c.complete},
            {"report", or_null(c.report.verdict)},
            {"report_text", or_null(c.report.text)}};
}

}  // namespace

json json_of(const Estimate& e, double systematic) {
    if (!std::isfinite(e.value)) return nullptr;
    json all{{"value", e.value}, {"sigma", e.sigma}};
    if (std::isfinite(systematic)) all["systematic"] = systematic;
    return all;
}

json asked_json(const std::optional<Drive>& drive) {
    if (!drive) return nullptr;
    return {{"frequency_hz", drive->frequency},
            {"gamma_mps2", drive->gamma},
            {"rho", drive->rho},
            {"phi_rad", drive->phi},
            {"overtones", overtones_json(*drive)}};
}

double number_from(const json& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    return found != object.end() && found->is_number() ? found->get<double>() : NAN;
}

std::string text_from(const json& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (found == object.end() || !found->is_string()) return {};
    std::string text = found->get<std::string>();
    text.resize(std::min(text.size(), longest_text));
    text.resize(text.size() - unfinished_bytes(text));
    return printable(text);
}

json json_of(const ResultRow& row) {
    json all{{"time", row.time.empty() ? json(nullptr) : json(row.time)},
             {"asked", asked_json(row.asked)},
             {"periods", row.periods},
             {"steady", row.steady},
             {"notes", row.notes},
             {"ended", row.ended},
             {"recording", row.recording.empty() ? json(nullptr) : json(row.recording)}};
    for (const ListedQuantity& l : listed_quantities) all[key_of(l)] = json_of(row.*l.member);
    return all;
}

ResultRow row_from(const json& from) {
    ResultRow row;
    row.time = text_from(from, "time");
    if (from.is_object()) row.asked = asked_from(from);
    row.periods = number_from(from, "periods");
    for (const ListedQuantity& l : listed_quantities)
        if (from.is_object()) row.*l.member = estimate_from(from, key_of(l));
    const auto steady = from.is_object() ? from.find("steady") : from.end();
    row.steady = steady != from.end() && steady->is_boolean() && steady->get<bool>();
    row.notes = text_from(from, "notes");
    row.ended = text_from(from, "ended");
    row.recording = text_from(from, "recording");
    return row;
}

std::string results_json(std::span<const NumberedRow> rows) {
    json list = json::array();
    for (const NumberedRow& r : rows) {
        json row = json_of(r.row);
        row["id"] = r.number;
        list.push_back(std::move(row));
    }
    return json{{"type", "results"}, {"results", list}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string repeats_json(std::span<const Repeats> all) {
    json list = json::array();
    for (const Repeats& r : all)
        list.push_back({{"asked", asked_json(r.asked)},
                        {"newest", or_null(r.newest)},
                        {"count", r.count},
                        {"v_D_mps", json_of(r.v_D)},
                        {"D_m", json_of(r.D)},
                        {"efficiency", json_of(r.efficiency)},
                        {"stated_mps", r.stated},
                        {"scatter_mps", r.scatter}});
    return json{{"repeats", list}}.dump();
}

std::string results_csv(std::span<const NumberedRow> rows) {
    std::string all =
        "time [UTC],asked_frequency [Hz],asked_gamma [m/s^2],asked_rho [1],asked_phi [rad],asked_overtones,"
        "periods [1]";
    for (const ListedQuantity& l : listed_quantities)
        all += fmt::format(",{0} [{1}],{0}_errors [{1}]", l.quantity.name, l.quantity.unit);
    all += ",steady [1],ended,notes,recording\r\n";
    for (const auto& [number, row] : rows) {
        const Drive none{.frequency = NAN, .gamma = NAN, .rho = NAN, .phi = NAN};
        const Drive& asked = row.asked ? *row.asked : none;
        all += row.time;
        for (const double x : {asked.frequency, asked.gamma, asked.rho, asked.phi})
            all += fmt::format(",{}", number_text(x));
        all += fmt::format(",{},{}", quoted(overtones_text(asked)), number_text(row.periods));
        for (const ListedQuantity& l : listed_quantities)
            all +=
                fmt::format(",{},{}", number_text((row.*l.member).value), number_text((row.*l.member).sigma));
        all += fmt::format(",{},{},{},{}\r\n", row.steady ? 1 : 0, quoted(row.ended), quoted(row.notes),
                           quoted(row.recording));
    }
    return all;
}

std::string list_json(std::span<const ListedRecording> recordings,
                      std::span<const ListedCampaign> campaigns) {
    json list = json::array(), folders = json::array();
    for (const ListedRecording& r : recordings) list.push_back(json_of(r));
    for (const ListedCampaign& c : campaigns) folders.push_back(json_of(c));
    return json{{"recordings", list}, {"campaigns", folders}}.dump(-1, ' ', false,
                                                                   json::error_handler_t::replace);
}

}  // namespace shaker::catalogue
