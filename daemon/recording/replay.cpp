#include "daemon/recording/replay.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <cmath>
#include <map>
#include <utility>

#include "daemon/acquisition/collector.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/recording/tables/track_table.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"

namespace shaker::recording {

namespace {

std::vector<acquisition::CameraStream> cameras_of(const recorded::RecordingHeader& header) {
    std::vector<acquisition::CameraStream> cameras;
    std::size_t first = 0;
    for (const View& view : header.views)
        cameras.push_back(
            {.view = view, .first_track = std::exchange(first, first + view.targets.size()), .untimed = {}});
    return cameras;
}

void add_frames(const recorded::RecordingReader& file, acquisition::Streams& streams) {
    for (std::size_t i = 0; i < streams.cameras.size(); ++i)
        for (const Frame& f : file.frames(streams.cameras[i].view.camera)) {
            add_stamps(streams, i, f);
            if (!f.mid_exposure) streams.cameras[i].untimed.push_back({f.tick, f.stamp, f.arrived});
        }
}

enum class Frames {
    from_pictures,  // pictures are tracked again
    stamps,         // recorded stamps, no pictures
    none            // no frames; the recorded tracks have final times
};

acquisition::Streams streams_of(const recorded::RecordingReader& file,
                                const recorded::RecordingHeader& header, Frames frames) {
    const bool pictures = frames == Frames::from_pictures;
    Rig rig = replay_rig(file, header, pictures);
    acquisition::Collector collector{rig, nullptr};
    acquisition::Streams& gathered = collector.streams();
    // A replayed rig has no DAC, and it has cameras only when their pictures are tracked again.
    gathered.dac_rate_hz = header.dac.rate_hz;
    if (frames == Frames::stamps) gathered.cameras = cameras_of(header);
    gathered.timebase = empty_timebase(gathered);
    read_all(collector);
    acquisition::Streams streams = std::move(gathered);
    for (const PlayTime& p : file.play_times()) add(streams, p);
    if (frames == Frames::stamps) add_frames(file, streams);
    streams.changes = file.changes();
    return streams;
}

struct Setting {
    double* value;
    Range range;
};

std::map<std::string, Setting> settings_of(ReplayOverrides& s) {
    constexpr double long_s = 1e7;
    AccelerometerInfo& a = s.header.accelerometer;
    std::map<std::string, Setting> all{
        {"from_s", {&s.from_s, {-long_s, long_s}}},
        {"to_s", {&s.to_s, {-long_s, long_s}}},
        {"frequency_hz", {&s.header.frequency_hz, drive_limits.frequency}},
        {"accelerometer.first_sample_s", {&a.first_sample_s, {-long_s, long_s}}},
        {"accelerometer.clock_uncertainty_s", {&a.clock_uncertainty_s, {0, 10}}},
        {"accelerometer.high_pass_hz", {&a.response.lower.hz, {0, 100}}},
        {"accelerometer.high_pass_error_hz", {&a.response.lower.error_hz, {0, 100}}},
        {"accelerometer.low_pass_hz", {&a.response.upper.hz, {0, 1e6}}},
        {"accelerometer.low_pass_error_hz", {&a.response.upper.error_hz, {0, 1e6}}},
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const char axis = "xyz"[k];
        all[fmt::format("accelerometer.offset_counts_{}", axis)] = {&a.offset_counts[k], {-1e9, 1e9}};
        all[fmt::format("accelerometer.mps2_per_count_{}", axis)] = {&a.mps2_per_count[k], {-1e3, 1e3}};
        all[fmt::format("accelerometer.shaker_axis_{}", axis)] = {&a.shaker_axis[k], {-1, 1}};
    }
    for (View& view : s.header.views) {
        all[view.camera + ".mm_per_px"] = {&view.mm_per_px, {1e-6, 1e4}};
        all[view.camera + ".scale_error"] = {&view.scale_error, {0, 1}};
        all[view.camera + ".distance_mm"] = {&view.distance_mm, {0, 1e7}};
        all[view.camera + ".trigger_delay_s"] = {&view.trigger_delay_s, {-1, 1}};
        for (Target& t : view.targets)
            all[fmt::format("{}.{}.offset_mm", view.camera, t.name)] = {&t.offset_mm, {-1e5, 1e5}};
    }
    return all;
}

}  // namespace

std::string why_not_from_pictures(const recorded::RecordingReader& file) {
    if (file.header().kind == "trip")
        return "the file has only the end of a run, and its targets have left the regions where tracking "
               "starts";
    if (file.frames_without_picture() == 0) return {};
    switch (file.header().pictures) {
        case recorded::KeptPictures::off:
            return "no pictures were kept";
        case recorded::KeptPictures::first_second:
            return "only the pictures of the first second were kept";
        default:
            return "not all pictures were kept";
    }
}

std::string why_not_followed_again(const recorded::RecordingReader& file) {
    const std::string why = why_not_from_pictures(file);
    if (!why.empty() || file.header().schema >= tracks_since) return why;
    return fmt::format("the file has version {}, and targets are followed otherwise since version {}",
                       file.header().schema, tracks_since);
}

acquisition::Streams replayed_streams(const recorded::RecordingReader& file,
                                      const recorded::RecordingHeader& header, bool pictures,
                                      std::vector<std::string>& notes) {
    acquisition::Streams streams = streams_of(file, header, pictures ? Frames::from_pictures : Frames::none);
    if (pictures)
        settle_times(streams, notes);
    else
        read_tracks(file, header, streams);
    return streams;
}

acquisition::Streams stored_streams(const recorded::RecordingReader& file, std::vector<std::string>& notes) {
    const recorded::RecordingHeader& header = file.header();
    acquisition::Streams streams = streams_of(file, header, Frames::stamps);
    read_tracks(file, header, streams);
    settle_times(streams, notes);
    return streams;
}

ReplayOverrides replay_settings(const recorded::RecordingReader& file, const std::vector<std::string>& set) {
    const MeasuredPart part = read_reduced_part(file);
    ReplayOverrides s{file.header(), part.from_s, part.to_s, false};
    const std::map<std::string, Setting> all = settings_of(s);
    bool corner_told = false, low_pass_told = false, error_told = false;
    for (const std::string& text : set) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos) throw InputError{"--set " + text + ": expected key=value"};
        const std::string key = text.substr(0, equals);
        const auto setting = all.find(key);
        if (setting == all.end()) {
            std::vector<std::string> keys;
            keys.reserve(all.size());
            for (const auto& [name, unused] : all) keys.push_back(name);
            throw InputError{
                fmt::format("--set {}: unknown key; expected one of {}", key, fmt::join(keys, ", "))};
        }
        *setting->second.value =
            parse_quantity("--set " + key, text.substr(equals + 1), Dimension::ratio, setting->second.range);
        s.changed = true;
        corner_told = corner_told || key.starts_with("accelerometer.high_pass");
        low_pass_told = low_pass_told || key == "accelerometer.low_pass_hz";
        error_told = error_told || key == "accelerometer.low_pass_error_hz";
    }
    if (LowerCorner& corner = s.header.accelerometer.response.lower; corner_told) {
        if (std::isinf(corner.error_hz)) corner.error_hz = LowerCorner::of_data_sheet * corner.hz;
        corner.poles = std::max(corner.poles, 1);
    }
    if (LowPass& pass = s.header.accelerometer.response.upper; low_pass_told && !error_told)
        pass.error_hz = LowerCorner::of_data_sheet * pass.hz;
    return s;
}

}  // namespace shaker::recording
