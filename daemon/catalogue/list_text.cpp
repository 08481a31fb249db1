#include "daemon/catalogue/list_text.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <nlohmann/json.hpp>

#include "daemon/catalogue/row_text.hpp"

namespace shaker::catalogue {

namespace {

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

std::string list_json(std::span<const ListedRecording> recordings,
                      std::span<const ListedCampaign> campaigns) {
    json list = json::array(), folders = json::array();
    for (const ListedRecording& r : recordings) list.push_back(json_of(r));
    for (const ListedCampaign& c : campaigns) folders.push_back(json_of(c));
    return json{{"recordings", list}, {"campaigns", folders}}.dump(-1, ' ', false,
                                                                   json::error_handler_t::replace);
}

}  // namespace shaker::catalogue
