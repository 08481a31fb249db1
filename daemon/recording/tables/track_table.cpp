#include "daemon/recording/tables/track_table.hpp"

namespace shaker::recording {

namespace {

using tracking::Fix;
using tracking::Track;

constexpr const char* time_column = "t";

double state_of(const Track& t) { return columns::number_of(t.fix.state); }

bool take_state(Track& t, double value) {
    return columns::take(t.fix.state, value) && value >= 0 &&
           value <= columns::number_of(tracking::TrackState::repeated);
}

constexpr std::array numbers{
    number<&Track::tick, &CameraTick::n>("frame", "1", "number of the exposure; missed exposures count"),
    number<&Track::time>(time_column, "s", "mid-exposure, master time", true),
    number<&Track::fix, &Fix::x_px>("x_px", "px", "column in the picture; NaN while the target is lost"),
    number<&Track::fix, &Fix::y_px>("y_px", "px", "row in the picture, positive downwards"),
    number<&Track::fix, &Fix::sd_px>("sd_px", "px", "standard error along the shaker's axis"),
    number<&Track::x_m>("x", "m", "position along the shaker's axis"),
    number<&Track::sd_m>("x_errors", "m", "standard error of x"),
    NumberColumn<Track>{"state", "1",
                        "0 ok, 1 degraded, 2 lost, 3 found again, 4 clipped, 5 perhaps at a neighbour's "
                        "place, 6 in a picture that is delivered twice or torn",
                        state_of, take_state}};

using simulated::PoseTruth;

constexpr std::array pose_numbers{
    number<&PoseTruth::tick, &CameraTick::n>("frame", "1", "number of the exposure"),
    number<&PoseTruth::time>("t", "s", "mid-exposure, master time"),
    number<&PoseTruth::base>("x_base", "m", "position of the base along the shaker's axis"),
    number<&PoseTruth::walker>("x_walker", "m", "position of the walker along the shaker's axis")};
constexpr Table<PoseTruth> pose_columns{"truth", "true positions in a simulated rig, one row per frame",
                                        pose_numbers};

struct Drift {
    double v_D = 0;
};
constexpr std::array drift_numbers{
    number<&Drift::v_D>("v_D", "m/s", "true drift velocity over the measured part")};
constexpr Table<Drift> drift_columns{"truth", "true drift in a simulated rig", drift_numbers};

std::string truth_path(const std::string& camera) { return std::string{pose_columns.path} + "/" + camera; }

}  // namespace

constexpr Table<Track> track_columns{
    "tracks",
    "positions of one target in the pictures of one camera, one row per frame",
    numbers,
    {},
    {.signal = "x", .axes = time_column}};

std::string track_path(const std::string& camera, const Target& target) {
    return "tracks/" + camera + "/" + target.name;
}

std::vector<RecordedTable> tables_of(const acquisition::Streams& streams) {
    std::vector<RecordedTable> tables;
    for (const acquisition::TargetTrack& t : streams.tracks)
        tables.push_back(table_of(track_columns, t.tracks, track_path(t.camera, t.target)));
    return tables;
}

void write_times(recorded::RecordingWriter& file, const acquisition::Streams& streams) {
    for (const acquisition::TargetTrack& t : streams.tracks) {
        const auto camera =
            std::ranges::find(streams.cameras, t.camera, [](const auto& c) { return c.view.camera; });
        if (camera != streams.cameras.end() && camera->dropped > 0) {
            // Frames that carry their times were written with them.
            if (!camera->untimed.empty())
                file.replace(track_path(t.camera, t.target) + "/" + time_column, camera->times_s);
            continue;
        }
        std::vector<double> times;
        times.reserve(t.tracks.size());
        for (const Track& k : t.tracks) times.push_back(seconds(k.time));
        file.replace(track_path(t.camera, t.target) + "/" + time_column, times);
    }
}

void read_tracks(const recorded::RecordingReader& file, const recorded::RecordingHeader& header,
                 acquisition::Streams& streams) {
    for (const View& view : header.views)
        for (const Target& target : view.targets) {
            acquisition::TargetTrack t = acquisition::track_of(view, target);
            t.tracks = read_rows(file, track_columns, track_path(view.camera, target));
            for (Track& k : t.tracks) acquisition::scale(k, view, target);
            streams.tracks.push_back(std::move(t));
        }
}

std::vector<recorded::GroupLayout> truth_places(const std::vector<View>& views) {
    std::vector<recorded::GroupLayout> places{places_of(drift_columns)};
    for (const View& view : views)
        places.push_back(layout_of(pose_columns, truth_path(view.camera), view.frame_rate_hz));
    return places;
}

void write_true_drift(recorded::RecordingWriter& file, double v_D) {
    write(file, numbers_of(drift_columns, Drift{v_D}));
}

void write_truth(recorded::RecordingWriter& file, const std::string& camera,
                 const std::vector<simulated::PoseTruth>& poses) {
    write(file, {table_of(pose_columns, poses, truth_path(camera))});
}

}  // namespace shaker::recording
