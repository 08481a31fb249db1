#include "drivers/footage/lab_session.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <set>

#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/footage/csv.hpp"
#include "drivers/footage/media.hpp"
#include "drivers/footage/picture_clock.hpp"
#include "drivers/quantity.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/time.hpp"
#include "drivers/view_settings.hpp"

namespace shaker::footage {

namespace {

std::string counted(const std::filesystem::path& times, std::size_t rows, const std::filesystem::path& media,
                    std::int64_t frames) {
    return times.string() + ": has " + std::to_string(rows) + " rows, but " + media.string() + " has " +
           std::to_string(frames) + " frames; expected one row per frame";
}

class MediaCamera final : public Camera {
public:
    MediaCamera(const LabCamera& description, std::unique_ptr<Media> media, PictureClock clock)
        : description_{description},
          view_{description.view},
          media_{std::move(media)},
          clock_{std::move(clock)} {
        view_.frame_rate_hz = clock_.rate_hz();
        const auto count = media_->count();
        if (clock_.rows() > 0 && count && *count != rows()) wrong_count(*count);
        require_exposure();
        more_ = media_->next(ahead_);
        if (!more_) throw InputError{description_.file.string() + ": has no pictures"};
    }

    [[nodiscard]] const View& view() const override { return view_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return {.taken = taken_, .lost = lost_}; }
    [[nodiscard]] bool ended() const noexcept override { return stopped_ || !more_; }
    void stop() noexcept override { stopped_ = true; }

    FramePtr read(std::chrono::milliseconds) override {
        if (ended()) return {};
        if (has_table() && given_ == rows()) wrong_count(given_ + remaining());
        auto frame = std::make_shared<Frame>();
        const PictureClock::Exposure exposure = clock_.exposure(ahead_.number, given_);
        const MasterTime time = master_time(exposure.t_s);
        frame->tick = CameraTick{exposure.tick};
        frame->quality = exposure.tick > last_tick_ + 1 ? Quality::gap : Quality::good;
        frame->mid_exposure = time;
        frame->arrived = HostTime{std::chrono::nanoseconds{std::llround(1e9 * seconds(time))}};
        if (given_ > 0) lost_ += static_cast<std::uint64_t>(exposure.tick - last_tick_ - 1);
        ++taken_;
        last_tick_ = exposure.tick;
        const PictureFormat format = media_->format();
        frame->width = format.width;
        frame->height = format.height;
        frame->bytes_per_pixel = format.bytes_per_pixel;
        frame->pixels = std::move(ahead_.pixels);
        ahead_ = {};
        ++given_;
        more_ = media_->next(ahead_);
        if (!more_ && has_table() && given_ != rows()) wrong_count(given_);
        return frame;
    }

private:
    [[nodiscard]] bool has_table() const noexcept { return clock_.rows() > 0; }
    [[nodiscard]] std::int64_t rows() const noexcept { return static_cast<std::int64_t>(clock_.rows()); }

    [[noreturn]] void wrong_count(std::int64_t frames) const {
        throw InputError{counted(*description_.times, clock_.rows(), description_.file, frames)};
    }

    // The median step of times may already be the longest possible exposure: only a clearly longer one is an
    // error.
    void require_exposure() const {
        const double most_s = (clock_.has_times() ? 1.01 : 1 + 1e-9) / view_.frame_rate_hz;
        if (view_.exposure_s > most_s)
            throw InputError{"camera \"" + view_.camera + "\": exposure_s = " + to_text(view_.exposure_s) +
                             " is longer than the time between frames, " + to_text(1 / view_.frame_rate_hz) +
                             " s"};
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
    PictureClock clock_;
    Picture ahead_;
    bool more_ = false;
    std::int64_t given_ = 0, last_tick_ = -1;
    std::atomic<std::uint64_t> taken_{0}, lost_{0};
    std::atomic<bool> stopped_ = false;
};

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

std::string unit_at(SettingsTable& table, std::string_view key, bool of_time) {
    std::string word = table.text(key, "");
    const CsvUnit* unit = unit_in(word);
    if (!word.empty() && (unit == nullptr || unit->of_time != of_time))
        table.fail(key, "\"" + word + "\" is not allowed: expected " +
                            (of_time ? "s, ms, us or ns" : "mps2, m/s^2, mm/s^2, g or mg"));
    return word;
}

CsvAccelerometerFile read_accelerometer(SettingsTable table) {
    CsvAccelerometerFile accelerometer;
    accelerometer.file = path_at(table, "file");
    accelerometer.rate_hz = optional_number(table, "rate_hz", {0.1, 1e7});
    if (accelerometer.rate_hz) {
        accelerometer.first_sample_s = table.number("first_sample_s", {-1e6, 1e6}, 0);
    } else {
        accelerometer.time = table.text("time");
        accelerometer.time_unit = unit_at(table, "time_unit", true);
    }
    accelerometer.unit = unit_at(table, "unit", false);
    accelerometer.axes = table.texts("axes", 1, 3);
    accelerometer.gravity = table.flag("gravity", accelerometer.axes.size() == 3);
    accelerometer.response = read_response(table, accelerometer.gravity);
    accelerometer.clock_uncertainty_s = table.number("clock_uncertainty_s", {0, 3600}, 0.02);
    accelerometer.shaker_axis = read_shaker_axis(table, accelerometer.axes.size());
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
    if (open.description.accelerometer) {
        OpenCsvAccelerometer opened = open_csv_accelerometer(*open.description.accelerometer);
        open.rig.accelerometer = std::move(opened.accelerometer);
        open.notes = std::move(opened.notes);
    }
    for (const LabCamera& camera : open.description.cameras) {
        auto media =
            open_media(camera.file, camera.times ? MissingNumbers::left_out : MissingNumbers::refused);
        PictureClock clock{camera, *media};
        for (const auto& notes : {media->notes(), clock.notes()})
            for (const std::string& note : notes)
                open.notes.push_back("camera \"" + camera.view.camera + "\": " + note);
        // It keeps one picture in memory besides those it has returned.
        open.rig.cameras.push_back(std::make_unique<MediaCamera>(camera, std::move(media), std::move(clock)));
    }
    return open;
}

}  // namespace shaker::footage
