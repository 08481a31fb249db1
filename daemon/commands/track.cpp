#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "daemon/acquisition/collector.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/sandbox/new_files.hpp"
#include "daemon/sandbox/session_rights.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/lab_session.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array track_arguments{
    Argument{.name = "SESSION",
             .help = "session.toml; drive and accelerometer are not needed",
             .kind = Kind::file},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FILE",
             .help = "CSV with the columns camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state",
             .kind = Kind::file,
             .otherwise = "a summary only"},
    manual::json_argument};

const char* word_for(tracking::TrackState s) {
    constexpr std::array words{"ok", "degraded", "lost", "reacquired"};
    return words.at(static_cast<std::size_t>(s));
}

std::string csv_of(const acquisition::Streams& streams) {
    std::string csv = "camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state\n";
    for (const acquisition::TargetTrack& t : streams.tracks) {
        for (const tracking::Track& k : t.tracks) {
            const std::string where = found(k.fix.state)
                                          ? fmt::format("{:.5f},{:.5f},{:.5f},{:.6f}", k.fix.x_px, k.fix.y_px,
                                                        k.fix.sd_px, 1e3 * k.x_m)
                                          : std::string{",,,"};
            csv += fmt::format("{},{},{:.9f},{},{},{}\n", t.camera, k.tick.n, seconds(k.time), t.target.name,
                               where, word_for(k.fix.state));
        }
    }
    return csv;
}

void write_all(int descriptor, std::string_view text, const std::string& name) {
    while (!text.empty()) {
        const ssize_t n = ::write(descriptor, text.data(), text.size());
        if (n < 0 && errno != EINTR) throw DeviceError{name + ": cannot be written: " + std::strerror(errno)};
        text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
    }
}

struct Spread {
    int count = 0;
    double mean = NAN;
    double rms = NAN;  // deviation from the mean
};

Spread spread_of(const std::vector<double>& x) {
    Spread s{static_cast<int>(x.size()), 0, 0};
    for (const double v : x) s.mean += v / s.count;
    for (const double v : x) s.rms += (v - s.mean) * (v - s.mean) / s.count;
    s.rms = std::sqrt(s.rms);
    return x.empty() ? Spread{} : s;
}

// Distances between two targets of one camera in frames that show both, px.
std::vector<double> distances(const acquisition::TargetTrack& a, const acquisition::TargetTrack& b) {
    std::vector<double> d;
    for (std::size_t i = 0; i < std::min(a.tracks.size(), b.tracks.size()); ++i) {
        const tracking::Fix &p = a.tracks[i].fix, &q = b.tracks[i].fix;
        if (found(p.state) && found(q.state)) d.push_back(std::hypot(q.x_px - p.x_px, q.y_px - p.y_px));
    }
    return d;
}

// Summary of one target: losses, standard error claimed by the tracker, spread of its positions, distance to
// the next target of its camera.
nlohmann::json track_summary(const acquisition::TargetTrack& t, const acquisition::TargetTrack* next) {
    std::vector<double> sd, x, y;
    for (const tracking::Track& k : t.tracks) {
        if (!found(k.fix.state)) continue;
        sd.push_back(k.fix.sd_px);
        x.push_back(k.fix.x_px);
        y.push_back(k.fix.y_px);
    }
    nlohmann::json j = {{"camera", t.camera},
                        {"target", t.target.name},
                        {"frames", t.tracks.size()},
                        {"frames_lost", t.tracks.size() - x.size()},
                        {"mean_sd_px", spread_of(sd).mean},
                        {"spread_x_px", spread_of(x).rms},
                        {"spread_y_px", spread_of(y).rms}};
    if (next == nullptr) return j;
    const Spread d = spread_of(distances(t, *next));
    j["next"] = next->target.name;
    j["next_distance_px"] = d.mean;
    j["next_distance_spread_px"] = d.rms;
    return j;
}

std::string line_of(const nlohmann::json& j) {
    const auto px = [&](const char* key) {
        const double x = j[key].get<double>();
        return std::isfinite(x) ? fmt::format("{:.4f}", x) : "-";
    };
    std::string s =
        fmt::format("{:<10} {:<10} {:>6} frames {:>5} lost   claimed sd {} px   spread x {} y {} px",
                    j["camera"].get<std::string>(), j["target"].get<std::string>(), j["frames"].get<int>(),
                    j["frames_lost"].get<int>(), px("mean_sd_px"), px("spread_x_px"), px("spread_y_px"));
    if (j.contains("next"))
        s += fmt::format("   to {}: {} px, spread {}", j["next"].get<std::string>(), px("next_distance_px"),
                         px("next_distance_spread_px"));
    return s;
}

// Tracks the targets of a session. out: CSV file, whose descriptor is `csv`; empty: only a summary is
// printed.
void track_session(const std::filesystem::path& file, const std::filesystem::path& out, int csv, bool json) {
    footage::OpenLabSession session = footage::open_lab_session(file);
    for (const std::string& note : session.notes) spdlog::info("{}", note);
    acquisition::Collector collector{session.rig, nullptr};
    read_all(collector);
    const acquisition::Streams& streams = collector.streams();
    if (!out.empty()) write_all(csv, csv_of(streams), out.string());
    nlohmann::json j = {{"frames", streams.frames}, {"targets", nlohmann::json::array()}};
    for (std::size_t i = 0; i < streams.tracks.size(); ++i) {
        const bool last =
            i + 1 == streams.tracks.size() || streams.tracks[i + 1].camera != streams.tracks[i].camera;
        j["targets"].push_back(track_summary(streams.tracks[i], last ? nullptr : &streams.tracks[i + 1]));
        if (!json) fmt::print("{}\n", line_of(j["targets"].back()));
    }
    if (json)
        fmt::print("{}\n", report::json_text(j));
    else if (!out.empty())
        fmt::print("tracks: {}\n", out.string());
}

int act_on_track(const manual::Values& values) {
    const std::filesystem::path file = values.text("SESSION"), out = values.text("--output");
    sandbox::SessionRights rights = sandbox::rights_for_session(file);
    if (rights.status != manual::exit_ok) return rights.status;
    std::optional<sandbox::NewFile> made;
    int csv = -1;
    if (!out.empty()) {
        csv = made.emplace(out).descriptor();
        rights.allowed.keeps = {csv};
    }
    return confined(file.string(), rights.allowed, [&] {
        track_session(file, out, csv, values.has("--json"));
        return manual::exit_ok;
    });
}

}  // namespace

manual::Command track_row() {
    return {.name = "track",
            .summary = "Track the targets of a session without reducing it",
            .arguments = track_arguments,
            .example = "shakerd track session.toml -o tracks.csv",
            .exit_statuses = {manual::exit_device},
            .act = act_on_track};
}

}  // namespace shaker::commands
