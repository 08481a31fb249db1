#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "daemon/acquisition/collector.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/sandbox/new_files.hpp"
#include "daemon/sandbox/session_rights.hpp"
#include "drivers/codecs/codecs.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/lab_session.hpp"
#include "drivers/footage/media.hpp"
#include "tracking/proposals.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array track_arguments{
    Argument{.name = "SESSION",
             .help = "session.toml; drive and accelerometer are not needed. With --init: a movie or picture",
             .kind = Kind::file},
    Argument{.name = "--init",
             .help = "Find targets in the first picture and write the session.toml for them"},
    Argument{.name = "--preview",
             .value = "FILE",
             .help = "JPEG of the first picture of each camera with its targets; nothing is tracked",
             .kind = Kind::file},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FILE",
             .help =
                 "CSV with the columns camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state; with --init the "
                 "session.toml",
             .kind = Kind::file,
             .otherwise = "a summary only; with --init standard output"},
    manual::json_argument};

std::string csv_of(const acquisition::Streams& streams) {
    std::string csv = "camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state\n";
    for (const acquisition::TargetTrack& t : streams.tracks) {
        for (const tracking::Track& k : t.tracks) {
            const std::string where = found(k.fix.state)
                                          ? fmt::format("{:.5f},{:.5f},{:.5f},{:.6f}", k.fix.x_px, k.fix.y_px,
                                                        k.fix.sd_px, 1e3 * k.x_m)
                                          : std::string{",,,"};
            csv += fmt::format("{},{},{:.9f},{},{},{}\n", t.camera, k.tick.n, seconds(k.time), t.target.name,
                               where, tracking::track_words.at(static_cast<std::size_t>(k.fix.state)));
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

/// Rights to read a movie, a picture, or the pictures of a folder.
sandbox::Confinement rights_for_media(const std::filesystem::path& file) {
    sandbox::Confinement allowed = sandbox::confinement_for(file);
    allowed.files = {};
    std::error_code missing;  // reported when it is opened
    for (const std::filesystem::path& name : footage::media_files(file))
        (std::filesystem::is_directory(name, missing) ? allowed.files.lists : allowed.files.reads)
            .push_back(name);
    allowed.prepare = footage::load_decoders;
    return allowed;
}

/// The targets in the first picture of `media`.
nlohmann::json proposals_in(const std::filesystem::path& media) {
    const auto pictures = footage::open_media(media, footage::MissingNumbers::refused);
    footage::Picture picture;
    if (!pictures->next(picture)) throw InputError{media.string() + ": has no picture"};
    const footage::PictureFormat f = pictures->format();
    const tracking::Proposals p =
        tracking::proposed_targets({picture.pixels.data(), f.width, f.height,
                                    std::ptrdiff_t{f.width} * f.bytes_per_pixel, f.bytes_per_pixel});
    if (p.targets.empty())
        throw InputError{fmt::format("{}: no target was found in its first picture{}{}", media.string(),
                                     p.refused.empty() ? "" : "; ", fmt::join(p.refused, "; "))};
    nlohmann::json found{{"has_rate", pictures->rate_hz().has_value()},
                         {"refused", p.refused},
                         {"targets", nlohmann::json::array()}};
    for (const Target& t : p.targets)
        found["targets"].push_back({{"kind", static_cast<int>(t.kind)},
                                    {"diameter_mm", t.diameter_mm},
                                    {"width_mm", t.width_mm},
                                    {"pitch_mm", t.pitch_mm},
                                    {"roi_px", t.roi_px},
                                    {"dark", t.polarity == Polarity::dark}});
    return found;
}

/// A session.toml. found: of proposals_in(), in a process that the picture may control.
std::string proposed_session(const nlohmann::json& found, const std::string& quoted_name) {
    std::string s =
        "# Proposed by \"shakerd track --init\". Lengths are in px: set mm_per_px, and multiply them by "
        "it.\n";
    for (std::string why : found.at("refused")) {
        std::ranges::replace_if(
            why, [](unsigned char c) { return c < ' ' || c == 0x7F; }, ' ');
        s += fmt::format("# not proposed: {}\n", why);
    }
    s += fmt::format("\n[[camera]]\nname = \"view\"\nfile = {}\nfirst_exposure_s = 0.0\n", quoted_name);
    if (!found.at("has_rate").get<bool>())
        s += "frame_rate_hz = 1000.0         # the file does not state it\n";
    s += "mm_per_px = 1.0\nalong = [1.0, 0.0]             # image direction of +x\n";
    std::array<int, target_kinds.size()> numbers{};
    for (const nlohmann::json& t : found.at("targets")) {
        const auto kind = t.at("kind").get<std::size_t>();
        s += fmt::format(
            "\n[[camera.target]]\nname = \"{0}{1}\"                 # \"walker\", \"base\", or any name\n"
            "kind = \"{0}\"\n",
            target_kinds.at(kind), ++numbers.at(kind));
        for (const char* key : {"diameter_mm", "width_mm", "pitch_mm"})
            if (const double px = t.at(key); px > 0) s += fmt::format("{} = {:.2f}\n", key, px);
        s += fmt::format("roi_px = [{}]\n", fmt::join(t.at("roi_px").get<std::array<int, 4>>(), ", "));
        if (t.at("dark").get<bool>()) s += "polarity = \"dark\"\n";
    }
    return s;
}

int act_on_init(const std::filesystem::path& media, const std::filesystem::path& out) {
    std::optional<sandbox::NewFile> made;
    if (!out.empty()) made.emplace(out);
    std::error_code unknown;
    const std::filesystem::path from = out.empty() ? "." : std::filesystem::absolute(out).parent_path();
    const std::filesystem::path whole = std::filesystem::absolute(media);  // links in its name stay
    const std::filesystem::path name =
        std::filesystem::proximate(whole.parent_path(), from, unknown) / whole.filename();
    std::string quoted;
    try {
        quoted = nlohmann::json((unknown ? whole : name).string()).dump();
    } catch (const nlohmann::json::exception&) {
        throw InputError{media.string() +
                         ": its name is not UTF-8 text, which a session.toml needs; rename it"};
    }
    const sandbox::Answer answer = sandbox::ask_confined(media.string(), rights_for_media(media), [&] {
        return proposals_in(media).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    });
    if (answer.status != manual::exit_ok) return answer.status;
    std::string text;
    try {
        text = proposed_session(nlohmann::json::parse(answer.text), quoted);
    } catch (const nlohmann::json::exception&) {
        throw InputError{media.string() + ": its reader answers wrongly"};
    } catch (const std::out_of_range&) {
        throw InputError{media.string() + ": its reader answers wrongly"};
    }
    if (out.empty())
        report::say(text);
    else
        write_all(made->descriptor(), text, out.string());
    return manual::exit_ok;
}

/// The first pictures of a session's cameras, one below the other, with their targets.
cv::Mat previewed(const std::filesystem::path& session) {
    constexpr int wait_ms = 1000, line = 16;  // px
    footage::OpenLabSession opened = footage::open_lab_session(session);
    std::vector<cv::Mat> parts;
    int width = 0;
    for (const auto& camera : opened.rig.cameras) {
        const FramePtr frame = camera->read(std::chrono::milliseconds{wait_ms});
        if (!frame) throw InputError{camera->view().camera + ": has no picture"};
        const cv::Mat grey{frame->height, frame->width, frame->bytes_per_pixel == 2 ? CV_16UC1 : CV_8UC1,
                           const_cast<std::byte*>(frame->view().pixels),
                           static_cast<std::size_t>(frame->view().stride)};
        cv::Mat part;
        cv::normalize(grey, part, 0, 255, cv::NORM_MINMAX, CV_8U);
        for (const Target& t : camera->view().targets) {
            const cv::Rect box{t.roi_px[0], t.roi_px[1], t.roi_px[2], t.roi_px[3]};
            for (const auto& [colour, thick] : {std::pair{0, 3}, {255, 1}}) {
                cv::rectangle(part, box, colour, thick);
                cv::putText(part, t.name,
                            {box.x + 2, box.y > line ? box.y - 4 : box.y + box.height + line - 4},
                            cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, thick);
            }
        }
        width = std::max(width, part.cols);
        parts.push_back(part);
    }
    for (cv::Mat& part : parts)
        cv::copyMakeBorder(part, part, 0, line, 0, width - part.cols, cv::BORDER_CONSTANT);
    cv::Mat all;
    cv::vconcat(parts, all);
    return all;
}

int act_on_preview(const std::filesystem::path& session, const std::filesystem::path& out) {
    sandbox::SessionRights rights = sandbox::rights_for_session(session);
    if (rights.status != manual::exit_ok) return rights.status;
    const sandbox::NewFile made{out};
    rights.allowed.keeps = {made.descriptor()};
    return confined(session.string(), rights.allowed, [&] {
        constexpr int quality = 92;
        const std::vector<unsigned char> jpeg = codecs::jpeg_of(previewed(session), quality);
        if (jpeg.empty())
            throw InputError{session.string() + ": its pictures are too large together for one JPEG file"};
        write_all(made.descriptor(), {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()}, out.string());
        return manual::exit_ok;
    });
}

int act_on_track(const manual::Values& values) {
    const std::filesystem::path file = values.text("SESSION"), out = values.text("--output");
    for (const auto& [one, other] : {std::pair{"--init", "--preview"},
                                     {"--init", "--json"},
                                     {"--preview", "--output"},
                                     {"--preview", "--json"}})
        if (values.has(one) && values.has(other))
            throw InputError{fmt::format("{} and {} exclude each other", one, other)};
    if (values.has("--init")) return act_on_init(file, out);
    if (values.has("--preview")) return act_on_preview(file, values.text("--preview"));
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
            .details = "--init writes a session.toml for a movie, --preview draws the targets of a session.",
            .arguments = track_arguments,
            .example = "shakerd track session.toml -o tracks.csv",
            .exit_statuses = {manual::exit_device},
            .act = act_on_track};
}

}  // namespace shaker::commands
