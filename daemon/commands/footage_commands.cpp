#include "daemon/commands/footage_commands.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/acquisition/collector.hpp"
#include "daemon/bench/region_camera.hpp"
#include "daemon/recording/recorder.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/report/results.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/lab_session.hpp"
#include "drivers/footage/media.hpp"

namespace shaker::commands {

namespace {

constexpr double everything = 1e300;

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in{file};
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

const char* word(tracking::TrackState s) {
    switch (s) {
        case tracking::TrackState::ok:
            return "ok";
        case tracking::TrackState::degraded:
            return "degraded";
        case tracking::TrackState::lost:
            return "lost";
        case tracking::TrackState::reacquired:
            return "reacquired";
    }
    return "lost";
}

// Prints the requested drive beside the measured one, if the session contains it.
void compare(const footage::AskedDrive& asked, const reduction::Reduction& r) {
    const auto line = [](const char* name, const std::optional<double>& want, double got, const char* unit) {
        if (want)
            fmt::print("  {:<22}{:>24} {} (requested {:.6g})\n", name, fmt::format("{:.6g}", got), unit,
                       *want);
    };
    fmt::print("measured and requested drive:\n");
    line("gamma", asked.gamma_mps2, r.gamma.value, "m/s^2");
    line("rho", asked.rho, r.rho.value, "");
    line("phi", asked.phi_rad, r.phi.value, "rad");
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
                               where, word(k.fix.state));
        }
    }
    return csv;
}

void write_csv(const TrackOptions& options, std::string_view text) {
    while (!text.empty()) {
        const ssize_t n = ::write(options.csv, text.data(), text.size());
        if (n < 0 && errno != EINTR)
            throw DeviceError{options.out.string() + ": cannot be written: " + std::strerror(errno)};
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

nlohmann::json number(double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(nullptr); }

// Summary of one target: losses, standard error claimed by the tracker, spread of its positions, distance to
// the next target of its camera.
nlohmann::json summary(const acquisition::TargetTrack& t, const acquisition::TargetTrack* next) {
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
                        {"mean_sd_px", number(spread_of(sd).mean)},
                        {"spread_x_px", number(spread_of(x).rms)},
                        {"spread_y_px", number(spread_of(y).rms)}};
    if (next == nullptr) return j;
    const Spread d = spread_of(distances(t, *next));
    j["next"] = next->target.name;
    j["next_distance_px"] = number(d.mean);
    j["next_distance_spread_px"] = number(d.rms);
    return j;
}

std::string line_of(const nlohmann::json& j) {
    const auto px = [&](const char* key) {
        return j[key].is_null() ? std::string{"-"} : fmt::format("{:.4f}", j[key].get<double>());
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

// A path cannot contain the character that ends each name.
constexpr char end_of_name = '\0';

void append_names(std::string& names, const std::vector<std::filesystem::path>& files, char kind) {
    for (const std::filesystem::path& file : files) names += kind + file.string() + end_of_name;
}

}  // namespace

std::string read_session_names(const std::filesystem::path& session) {
    const footage::NamedFiles named = named_files(footage::read_lab_session(session));
    std::string names;
    append_names(names, named.media, 'm');
    append_names(names, named.tables, 't');
    return names;
}

SessionFiles session_files(const std::filesystem::path& session, std::string_view names) {
    SessionFiles all;
    all.files.push_back(session);
    for (std::size_t end = 0; (end = names.find(end_of_name)) != std::string_view::npos;
         names.remove_prefix(end + 1)) {
        const std::string_view name = names.substr(0, end);
        if (name.size() < 2) continue;
        std::vector<std::filesystem::path> files{name.substr(1)};
        if (name.front() == 'm') files = footage::media_files(files.front());
        std::error_code missing;  // reported when it is opened
        for (std::filesystem::path& file : files) {
            if (std::filesystem::is_directory(file, missing)) {
                all.folders.push_back(std::move(file));
                continue;
            }
            const std::uintmax_t size = std::filesystem::file_size(file, missing);
            all.bytes += missing ? 0 : size;
            all.files.push_back(std::move(file));
        }
    }
    return all;
}

void load_decoders() noexcept { footage::load_decoders(); }

void require_new_recording(const ReduceOptions& options) { recording::require_new(options.out); }

void reduce_session(const ReduceOptions& options) {
    footage::OpenLabSession session = footage::open_lab_session(options.session);
    require_reducible(session.description);
    for (const std::string& note : session.notes) spdlog::info("{}", note);
    recorded::RecordingHeader header;
    header.title = session.description.title;
    header.kind = "session";
    header.config = text_of(options.session);
    header.frequency_hz = session.description.drive->frequency_hz;
    header.dac.rate_hz = 0;
    header.accelerometer = session.rig.accelerometer->info();
    if (options.pictures == recorded::KeptPictures::region && !options.out.empty())
        bench::take_regions(session.rig);
    for (const auto& camera : session.rig.cameras) header.views.push_back(camera->view());
    header.pictures = options.pictures;
    recording::lay_out(header, false);

    recording::Recorder recording{options.out, header, {.unfinished = recording::Unfinished::discard}};
    acquisition::Collector collector{session.rig, &recording};
    spdlog::info("tracking {} cameras", session.rig.cameras.size());
    read_all(collector);
    const acquisition::Streams& streams = collector.streams();
    reduction::Reduction r = reduce(measurement_of(streams, header.frequency_hz, -everything, everything));
    for (std::string& note : notes_on(streams)) r.notes.push_back(std::move(note));
    recording.finish(streams, r, -everything, everything);
    if (options.json) {
        std::fputs((report::results_json(r) + "\n").c_str(), stdout);
        return;
    }
    fmt::print("{}: {}\n", options.session.string(), header.title);
    std::fputs(report::results_text(r).c_str(), stdout);
    compare(*session.description.drive, r);
}

void track_session(const TrackOptions& options) {
    footage::OpenLabSession session = footage::open_lab_session(options.session);
    for (const std::string& note : session.notes) spdlog::info("{}", note);
    acquisition::Collector collector{session.rig, nullptr};
    read_all(collector);
    const acquisition::Streams& streams = collector.streams();
    if (!options.out.empty()) write_csv(options, csv_of(streams));
    nlohmann::json j = {{"frames", streams.frames}, {"targets", nlohmann::json::array()}};
    for (std::size_t i = 0; i < streams.tracks.size(); ++i) {
        const bool last =
            i + 1 == streams.tracks.size() || streams.tracks[i + 1].camera != streams.tracks[i].camera;
        j["targets"].push_back(summary(streams.tracks[i], last ? nullptr : &streams.tracks[i + 1]));
        if (!options.json) fmt::print("{}\n", line_of(j["targets"].back()));
    }
    if (options.json)
        fmt::print("{}\n", report::json_text(j));
    else if (!options.out.empty())
        fmt::print("tracks: {}\n", options.out.string());
}

}  // namespace shaker::commands
