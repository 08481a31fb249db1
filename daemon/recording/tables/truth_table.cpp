#include "daemon/recording/tables/truth_table.hpp"

namespace shaker::recording {

namespace {

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
