#include "daemon/recording/replayed_streams.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "daemon/acquisition/collector.hpp"
#include "daemon/acquisition/executors.hpp"
#include "daemon/recording/tables/track_table.hpp"
#include "drivers/ticks.hpp"

namespace shaker::recording {

namespace {

// Delays the replay to real time and logs a line each second.
class SlowReplay {
public:
    void follow(const acquisition::Streams& streams) {
        if (streams.blocks.empty()) return;
        const double now_s = counted_s(streams.blocks.back().first, streams.accelerometer.rate_hz);
        pacer_.wait_until(now_s);
        if (now_s < logged_s_ + 1) return;
        logged_s_ = now_s;
        std::string line = fmt::format("{:9.3f} s  {} frames", now_s, streams.frames);
        for (const acquisition::TargetTrack& t : streams.tracks)
            if (!t.tracks.empty())
                line += fmt::format("  {}/{} {:.3f} mm", t.camera, t.target.name, 1e3 * t.tracks.back().x_m);
        spdlog::info("{}", line);
    }

private:
    acquisition::Pacer pacer_;
    double logged_s_ = 0;
};

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
                                const recorded::RecordingHeader& header, Frames frames, bool real_time) {
    const bool pictures = frames == Frames::from_pictures;
    Rig rig = replay_rig(file, header, pictures);
    acquisition::Collector collector{rig, nullptr};
    acquisition::Streams& gathered = collector.streams();
    // A replayed rig has no DAC, and it has cameras only when their pictures are tracked again.
    gathered.dac_rate_hz = header.dac.rate_hz;
    if (frames == Frames::stamps) gathered.cameras = cameras_of(header);
    gathered.timebase = empty_timebase(gathered);
    SlowReplay slow;
    read_all(collector, [&] {
        if (real_time) slow.follow(gathered);
    });
    acquisition::Streams streams = std::move(gathered);
    for (const PlayTime& p : file.play_times()) add(streams, p);
    if (frames == Frames::stamps) add_frames(file, streams);
    streams.changes = file.changes();
    return streams;
}

}  // namespace

std::string why_not_from_pictures(const recorded::RecordingReader& file) {
    if (file.header().kind == "trip")
        return "the file has only the end of a run, and its targets have left the regions where tracking "
               "starts";
    if (file.frames_without_picture() == 0) return {};
    return file.header().pictures == recorded::KeptPictures::off ? "no pictures were kept"
                                                                 : "not all pictures were kept";
}

acquisition::Streams replayed_streams(const recorded::RecordingReader& file,
                                      const recorded::RecordingHeader& header, bool pictures, bool real_time,
                                      std::vector<std::string>& notes) {
    acquisition::Streams streams =
        streams_of(file, header, pictures ? Frames::from_pictures : Frames::none, real_time);
    if (pictures)
        settle_times(streams, notes);
    else
        read_tracks(file, header, streams);
    return streams;
}

acquisition::Streams stored_streams(const recorded::RecordingReader& file, std::vector<std::string>& notes) {
    const recorded::RecordingHeader& header = file.header();
    acquisition::Streams streams = streams_of(file, header, Frames::stamps, false);
    read_tracks(file, header, streams);
    settle_times(streams, notes);
    return streams;
}

}  // namespace shaker::recording
