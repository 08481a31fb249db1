#include "daemon/recording/replayed_streams.hpp"

#include <utility>

#include "daemon/acquisition/collector.hpp"
#include "daemon/recording/tables/track_table.hpp"

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

}  // namespace shaker::recording
