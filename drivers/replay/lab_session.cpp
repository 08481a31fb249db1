#include "drivers/replay/lab_session.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/replay/media_camera.hpp"
#include "drivers/settings_table.hpp"

namespace shaker {
namespace {

constexpr Range length_mm{1e-4, 1e5};
constexpr Range frame_rate_hz{1e-3, 1e8};
constexpr double unit_length_tolerance = 1e-3;
constexpr double two_turns = 2 * two_pi;

std::filesystem::path path_at(SettingsTable& table, std::string_view key) {
    const std::string text = table.text(key);
    if (text.empty()) table.fail(key, "a file name was expected");
    std::filesystem::path path = table.folder() / text;
    const bool pattern = path.filename().string().find('%') != std::string::npos;
    if (!std::filesystem::exists(pattern ? path.parent_path() : path) && !path.parent_path().empty())
        table.fail(key, "\"" + path.string() + "\": No such file or directory");
    return path;
}

/// A vector that should have unit length, made exactly so.
template <std::size_t size>
std::array<double, size> unit_vector(SettingsTable& table, std::string_view key) {
    const std::vector<double> given = table.numbers(key, size);
    double length = 0;
    for (const double c : given) length = std::hypot(length, c);
    if (!(std::abs(length - 1) <= unit_length_tolerance))
        table.fail(key, "a vector of length 1 was expected, this one has length " + to_text(length));
    std::array<double, size> unit{};
    for (std::size_t i = 0; i < size; ++i) unit[i] = given[i] / length;
    return unit;
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
        accelerometer.shaker_axis = unit_vector<3>(table, "shaker_axis");
    table.finish();
    return accelerometer;
}

/// Names go into file names, column names and tables of text.
std::string name_at(SettingsTable& table, std::set<std::string>& taken) {
    std::string name = table.text("name");
    const auto odd = [](unsigned char c) { return c < ' ' || c == ',' || c == '"' || c == '/' || c == 0x7F; };
    if (name.empty() || std::any_of(name.begin(), name.end(), odd))
        table.fail("name", "a name without commas, quotes, slashes and control characters was expected");
    if (!taken.insert(name).second) table.fail("name", "\"" + name + "\" is there twice");
    return name;
}

std::array<int, 4> read_roi(SettingsTable& table) {
    constexpr double most_px = 65536;
    const std::vector<double> given = table.numbers("roi_px", 4);
    std::array<int, 4> roi{};
    for (std::size_t i = 0; i < 4; ++i) {
        const double least = i < 2 ? 0 : 1;
        if (given[i] != std::floor(given[i]) || given[i] < least || given[i] > most_px)
            table.fail("roi_px",
                       "x, y, width, height in whole pixels were expected, x and y at least 0, width and "
                       "height at least 1; " +
                           to_text(given[i]) + " is not allowed");
        roi[i] = static_cast<int>(given[i]);
    }
    return roi;
}

Target read_target(SettingsTable& table, std::set<std::string>& names, double distance_mm) {
    constexpr TargetKind kinds[] = {TargetKind::disc, TargetKind::rectangle, TargetKind::dots,
                                    TargetKind::bars, TargetKind::patch};
    Target target;
    target.name = name_at(table, names);
    target.kind = kinds[table.choice("kind", {"disc", "rectangle", "dots", "bars", "patch"})];
    const auto length = [&](std::string_view key, std::initializer_list<TargetKind> needed_by) {
        const bool needed = std::find(needed_by.begin(), needed_by.end(), target.kind) != needed_by.end();
        return needed ? table.number(key, length_mm) : table.number(key, length_mm, 0);
    };
    target.diameter_mm = length("diameter_mm", {TargetKind::disc, TargetKind::dots});
    target.width_mm = length("width_mm", {TargetKind::rectangle});
    target.pitch_mm = length("pitch_mm", {TargetKind::bars});
    if (target.kind == TargetKind::dots && target.pitch_mm > 0 && target.pitch_mm <= target.diameter_mm)
        table.fail("pitch_mm", "must be more than diameter_mm, which is " + to_text(target.diameter_mm));
    target.roi_px = read_roi(table);
    target.offset_mm = table.number("offset_mm", {-1e5, 1e5}, 0);
    if (distance_mm > 0 && target.offset_mm >= distance_mm)
        table.fail("offset_mm", to_text(target.offset_mm) +
                                    " is not allowed: less than the camera's distance_mm, " +
                                    to_text(distance_mm) + ", was expected");
    target.polarity =
        table.choice("polarity", {"bright", "dark"}, 0) == 0 ? Polarity::bright : Polarity::dark;
    table.finish();
    return target;
}

LabCamera read_camera(SettingsTable& table, std::set<std::string>& names) {
    LabCamera camera;
    View& view = camera.view;
    view.camera = name_at(table, names);
    camera.file = path_at(table, "file");
    if (table.has("times")) camera.times = path_at(table, "times");
    camera.frame_rate_hz = optional_number(table, "frame_rate_hz", frame_rate_hz);
    constexpr Range session_s{-1e6, 1e6};
    camera.first_exposure_s = camera.times ? table.number("first_exposure_s", session_s, 0)
                                           : table.number("first_exposure_s", session_s);
    view.exposure_s = table.number("exposure_s", {0, 1e3}, 0);
    if (camera.frame_rate_hz && view.exposure_s * *camera.frame_rate_hz > 1)
        table.fail("exposure_s",
                   to_text(view.exposure_s) + " is not allowed: at most the time between frames, " +
                       to_text(1 / *camera.frame_rate_hz) +
                       " s at frame_rate_hz = " + to_text(*camera.frame_rate_hz) + ", was expected");
    view.frame_rate_hz = camera.frame_rate_hz.value_or(0);
    view.mm_per_px = table.number("mm_per_px", {1e-6, 1e4});
    view.distance_mm = table.number("distance_mm", {1, 1e7}, 0);
    if (table.has("along")) view.along = unit_vector<2>(table, "along");
    std::set<std::string> target_names;
    for (SettingsTable& target : table.tables("target"))
        view.targets.push_back(read_target(target, target_names, view.distance_mm));
    if (view.targets.empty())
        table.fail("target", "camera \"" + view.camera +
                                 "\" has nothing to follow: at least one [[camera.target]] "
                                 "was expected");
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
    if (session.cameras.empty()) root.fail("camera", "at least one [[camera]] was expected");
    return session;
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

}  // namespace shaker
