#include "drivers/footage/lab_session.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <set>
#include <string>

#include "drivers/devices.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/csv.hpp"
#include "drivers/footage/media.hpp"
#include "drivers/quantity.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/time.hpp"
#include "drivers/view_settings.hpp"

namespace shaker::footage {

namespace {

struct OpenCamera {
    std::unique_ptr<Camera> camera;  // keeps one picture in memory besides those it has returned
    std::string note;                // properties of the file that the user should know; may be empty
};

std::vector<double> read_times(const std::filesystem::path& file) {
    const std::array<std::string, 1> column{"t_s"};
    const CsvColumns table = read_csv(file, column);
    require_increasing(table);
    return table.values.front();
}

double median_step(const std::vector<double>& t) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
}

std::string counted(const std::filesystem::path& times, std::size_t rows, const std::filesystem::path& media,
                    std::int64_t frames) {
    return times.string() + ": has " + std::to_string(rows) + " rows, but " + media.string() + " has " +
           std::to_string(frames) + " frames; expected one row per frame";
}

class MediaCamera final : public Camera {
public:
    MediaCamera(const LabCamera& description, std::unique_ptr<Media> media)
        : description_{description}, view_{description.view}, media_{std::move(media)} {
        if (description_.times) times_ = read_times(*description_.times);
        const auto count = media_->count();
        if (description_.times && count && *count != static_cast<std::int64_t>(times_.size()))
            wrong_count(*count);
        find_rate();
        more_ = media_->next(ahead_);
        if (!more_) throw InputError{description_.file.string() + ": has no pictures"};
    }

    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] bool ended() const noexcept override { return stopped_ || !more_; }
    void stop() noexcept override { stopped_ = true; }

    FramePtr read(std::chrono::milliseconds) override {
        if (ended()) return {};
        auto frame = std::make_shared<Frame>();
        const MasterTime time = stamp(*frame);
        frame->mid_exposure = time;
        frame->arrived = HostTime{std::chrono::nanoseconds{std::llround(1e9 * seconds(time))}};
        const PictureFormat format = media_->format();
        frame->width = format.width;
        frame->height = format.height;
        frame->bytes_per_pixel = format.bytes_per_pixel;
        frame->pixels = std::move(ahead_.pixels);
        ahead_ = {};
        ++given_;
        more_ = media_->next(ahead_);
        if (!more_ && description_.times && given_ != times_.size())
            wrong_count(static_cast<std::int64_t>(given_));
        return frame;
    }

private:
    [[noreturn]] void wrong_count(std::int64_t frames) const {
        throw InputError{counted(*description_.times, times_.size(), description_.file, frames)};
    }

    void find_rate() {
        if (view_.frame_rate_hz <= 0 && times_.size() > 1) view_.frame_rate_hz = 1 / median_step(times_);
        if (view_.frame_rate_hz <= 0) view_.frame_rate_hz = media_->rate_hz().value_or(0);
        const std::string camera = "camera \"" + view_.camera + "\": ";
        if (view_.frame_rate_hz <= 0)
            throw InputError{camera + description_.file.string() +
                             " does not state its frame rate; set frame_rate_hz or "
                             "times"};
        // The median step of `times` may already be the longest possible exposure: only a clearly longer one
        // is an error.
        const double most_s = (description_.times ? 1.01 : 1 + 1e-9) / view_.frame_rate_hz;
        if (view_.exposure_s > most_s)
            throw InputError{camera + "exposure_s = " + to_text(view_.exposure_s) +
                             " is longer than the time between frames, " + to_text(1 / view_.frame_rate_hz) +
                             " s"};
    }

    /// Tick, quality and time of the next frame.
    MasterTime stamp(Frame& frame) {
        if (!description_.times) {
            tick_ += 1 + ahead_.missed;
            frame.quality = ahead_.missed > 0 ? Quality::gap : Quality::good;
            frame.tick = CameraTick{tick_};
            return master_time(description_.first_exposure_s + duration_s(tick_, view_.frame_rate_hz));
        }
        if (given_ == times_.size()) wrong_count(static_cast<std::int64_t>(given_) + remaining());
        const double t = times_[given_];
        const double since_last = given_ > 0 ? t - times_[given_ - 1] : 0;
        const double steps =
            given_ > 0 ? std::clamp(std::round(since_last * view_.frame_rate_hz), 1.0, 1e15) : 1.0;
        tick_ += static_cast<std::int64_t>(steps);
        frame.quality = steps > 1 ? Quality::gap : Quality::good;
        frame.tick = CameraTick{tick_};
        return master_time(t);
    }

    /// Number of pictures from the next one to the end of the file.
    std::int64_t remaining() {
        std::int64_t n = 1;
        while (media_->next(ahead_)) ++n;
        return n;
    }

    LabCamera description_;
    View view_;
    std::unique_ptr<Media> media_;
    std::vector<double> times_;
    Picture ahead_;
    bool more_ = false;
    std::size_t given_ = 0;
    std::int64_t tick_ = -1;
    std::atomic<bool> stopped_ = false;
};

/// Opens a camera's file and times. view().frame_rate_hz: from the description, else from `times` (median
/// step), else from the file. Throws InputError with the file; see open_lab_session.
OpenCamera open_media_camera(const LabCamera& description) {
    auto media =
        open_media(description.file, description.times ? MissingNumbers::left_out : MissingNumbers::refused);
    const std::string note = media->note();
    return {std::make_unique<MediaCamera>(description, std::move(media)), note};
}

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
