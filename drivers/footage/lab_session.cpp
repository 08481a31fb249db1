#include "drivers/footage/lab_session.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/media_camera.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/view_settings.hpp"

namespace shaker::footage {
namespace {

constexpr double two_turns = 2 * two_pi;

std::filesystem::path path_at(SettingsTable& table, std::string_view key) {
    const std::string text = table.text(key);
    if (text.empty()) table.fail(key, "expected a file name");
    std::filesystem::path path = table.folder() / text;
    const bool pattern = path.filename().string().find('%') != std::string::npos;
    if (!std::filesystem::exists(pattern ? path.parent_path() : path) && !path.parent_path().empty())
        table.fail(key, "\"" + path.string() + "\": No such file or directory");
    return path;
}

std::optional<double> optional_number(SettingsTable& table, std::string_view key, Range allowed) {
    if (!table.has(key)) return {};
    return table.number(key, allowed);
}

AskedDrive read_drive(SettingsTable table) {
    AskedDrive drive;
    drive.frequency_hz = table.number("frequency_hz", {0.1, 5000});
    drive.gamma_mps2 = optional_number(table, "gamma_mps2", {0, 1e4});
    drive.rho = optional_number(table, "rho", {0, 1});
    drive.phi_rad = optional_number(table, "phi_rad", {-two_turns, two_turns});
    table.finish();
    return drive;
}

CsvAccelerometerFile read_accelerometer(SettingsTable table) {
    CsvAccelerometerFile accelerometer;
    accelerometer.file = path_at(table, "file");
    accelerometer.time = table.text("time");
    const std::vector<std::string> axes = table.texts("axes", 3);
    std::copy(axes.begin(), axes.end(), accelerometer.axes.begin());
    accelerometer.clock_uncertainty_s = table.number("clock_uncertainty_s", {0, 3600}, 0.02);
    if (table.is_text("shaker_axis") || !table.has("shaker_axis"))
        table.choice("shaker_axis", {"fit"}, 0);
    else
        accelerometer.shaker_axis = read_axis(table, "shaker_axis");
    table.finish();
    return accelerometer;
}

LabCamera read_camera(SettingsTable& table, std::set<std::string>& names) {
    LabCamera camera;
    camera.view = read_view(table, names);
    camera.file = path_at(table, "file");
    if (table.has("times")) camera.times = path_at(table, "times");
    if (camera.view.frame_rate_hz > 0) camera.frame_rate_hz = camera.view.frame_rate_hz;
    constexpr Range session_s{-1e6, 1e6};
    camera.first_exposure_s = camera.times ? table.number("first_exposure_s", session_s, 0)
                                           : table.number("first_exposure_s", session_s);
    table.finish();
    return camera;
}

bool has_target(const LabSession& session, std::string_view name) {
    for (const LabCamera& camera : session.cameras)
        for (const Target& target : camera.view.targets)
            if (target.name == name) return true;
    return false;
}

}  // namespace

LabSession read_lab_session(const std::filesystem::path& file) {
    LabSession session;
    session.file = file;
    SettingsTable root = SettingsTable::from_file(file);
    session.title = root.text("title", file.stem().string());
    if (root.has("drive")) session.drive = read_drive(root.table("drive"));
    if (root.has("accelerometer")) session.accelerometer = read_accelerometer(root.table("accelerometer"));
    std::set<std::string> names;
    for (SettingsTable& camera : root.tables("camera")) session.cameras.push_back(read_camera(camera, names));
    root.finish();
    if (session.cameras.empty()) root.fail("camera", "expected at least one [[camera]]");
    return session;
}

NamedFiles named_files(const LabSession& session) {
    NamedFiles files;
    if (session.accelerometer) files.tables.push_back(session.accelerometer->file);
    for (const LabCamera& camera : session.cameras) {
        files.media.push_back(camera.file);
        if (camera.times) files.tables.push_back(*camera.times);
    }
    return files;
}

void require_reducible(const LabSession& session) {
    const auto require = [&](bool is_there, const std::string& what) {
        if (!is_there) throw InputError{session.file.string() + ": to reduce this session, " + what};
    };
    require(session.drive.has_value(), "[drive] must give frequency_hz");
    require(session.accelerometer.has_value(), "[accelerometer] must name the table of accelerations");
    for (const char* name : {"walker", "base"})
        require(has_target(session, name),
                "a camera must have a [[camera.target]] with the name \"" + std::string{name} + "\"");
}

OpenLabSession open_lab_session(const std::filesystem::path& file) {
    OpenLabSession open;
    open.description = read_lab_session(file);
    open.rig.name = file.string();
    if (open.description.accelerometer)
        open.rig.accelerometer = open_csv_accelerometer(*open.description.accelerometer);
    for (const LabCamera& camera : open.description.cameras) {
        OpenCamera opened = open_media_camera(camera);
        open.rig.cameras.push_back(std::move(opened.camera));
        if (!opened.note.empty())
            open.notes.push_back("camera \"" + camera.view.camera + "\": " + opened.note);
    }
    return open;
}

}  // namespace shaker::footage
