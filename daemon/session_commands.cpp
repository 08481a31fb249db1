#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/acquisition.hpp"
#include "daemon/commands.hpp"
#include "daemon/recording.hpp"
#include "daemon/results.hpp"
#include "drivers/errors.hpp"
#include "drivers/replay/lab_session.hpp"

namespace shaker {

namespace {

constexpr double everything = 1e300;

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in{file};
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

const char* word(TrackState s) {
    switch (s) {
        case TrackState::ok: return "ok";
        case TrackState::degraded: return "degraded";
        case TrackState::lost: return "lost";
        case TrackState::reacquired: return "reacquired";
    }
    return "lost";
}

// What was asked of the shaker beside what it did, where the session says it.
void compare(const AskedDrive& asked, const Reduction& r) {
    const auto line = [](const char* name, const std::optional<double>& want, double got, const char* unit) {
        if (want) fmt::print("  {:<22}{:>24} {} (asked {:.6g})\n", name, fmt::format("{:.6g}", got), unit, *want);
    };
    fmt::print("asked and measured:\n");
    line("gamma", asked.gamma_mps2, r.gamma.value, "m/s^2");
    line("rho", asked.rho, r.rho.value, "");
    line("phi", asked.phi_rad, r.phi.value, "rad");
}

std::string csv_of(const Take& take) {
    std::string csv = "camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state\n";
    for (const TargetTrack& t : take.tracks) {
        for (const Track& k : t.tracks) {
            const std::string where = found(k.fix.state)
                                          ? fmt::format("{:.5f},{:.5f},{:.5f},{:.6f}", k.fix.x_px, k.fix.y_px,
                                                        k.fix.sd_px, 1e3 * k.x_m)
                                          : std::string{",,,"};
            csv += fmt::format("{},{},{:.9f},{},{},{}\n", t.camera, k.tick.n, seconds(k.time), t.target.name, where,
                               word(k.fix.state));
        }
    }
    return csv;
}

int lost_of(const TargetTrack& t) {
    return static_cast<int>(std::ranges::count_if(t.tracks, [](const Track& k) { return !found(k.fix.state); }));
}

}  // namespace

void reduce_session(const ReduceOptions& options) {
    OpenLabSession session = open_lab_session(options.session);
    require_reducible(session.description);
    for (const std::string& note : session.notes) spdlog::info("{}", note);
    SessionHeader header;
    header.title = session.description.title;
    header.kind = "session";
    header.config = text_of(options.session);
    header.frequency_hz = session.description.drive->frequency_hz;
    header.dac.rate_hz = 0;
    header.accelerometer = session.rig.accelerometer->info();
    for (const auto& camera : session.rig.cameras) header.views.push_back(camera->view());
    header.keep_frames = options.keep_frames;

    Recording recording{options.out, header, Recording::Unfinished::discard};
    Acquisition acquisition{session.rig, recording.writer()};
    spdlog::info("tracking {} cameras", session.rig.cameras.size());
    read_all(acquisition);
    const Take& take = acquisition.take();
    const Reduction r = reduce(measurement_of(take, header.frequency_hz, -everything, everything));
    recording.finish(take, r, -everything, everything);
    if (options.json) {
        std::fputs((results_json(r) + "\n").c_str(), stdout);
        return;
    }
    fmt::print("{}: {}\n", options.session.string(), header.title);
    std::fputs(results_text(r).c_str(), stdout);
    compare(*session.description.drive, r);
    if (!options.out.empty()) fmt::print("recorded: {}\n", options.out.string());
}

void track_session(const TrackOptions& options) {
    OpenLabSession session = open_lab_session(options.session);
    for (const std::string& note : session.notes) spdlog::info("{}", note);
    Acquisition acquisition{session.rig, nullptr};
    read_all(acquisition);
    const Take& take = acquisition.take();
    if (!options.out.empty()) {
        std::ofstream out{options.out, std::ios::binary};
        out << csv_of(take);
        out.close();
        if (!out) throw DeviceError{options.out.string() + ": cannot be written"};
    }
    nlohmann::json j = {{"frames", take.frames}, {"targets", nlohmann::json::array()}};
    for (const TargetTrack& t : take.tracks) {
        double sd = 0;
        for (const Track& k : t.tracks)
            if (found(k.fix.state)) sd += k.fix.sd_px;
        const int lost = lost_of(t), good = static_cast<int>(t.tracks.size()) - lost;
        const nlohmann::json mean_sd = good > 0 ? nlohmann::json(sd / good) : nlohmann::json(nullptr);
        j["targets"].push_back({{"camera", t.camera}, {"target", t.target.name}, {"frames", t.tracks.size()},
                                {"frames_lost", lost}, {"mean_sd_px", mean_sd}});
        if (!options.json)
            fmt::print("{:<10} {:<12} {:>6} frames, {:>4} lost, mean standard deviation {} px\n", t.camera,
                       t.target.name, t.tracks.size(), lost, good > 0 ? fmt::format("{:.4f}", sd / good) : "-");
    }
    if (options.json) fmt::print("{}\n", j.dump(2));
    else if (!options.out.empty()) fmt::print("tracks: {}\n", options.out.string());
}

}  // namespace shaker
