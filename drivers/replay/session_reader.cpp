#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/errors.hpp"
#include "drivers/replay/opened_session.hpp"

namespace shaker {

namespace {

int whole(hid_t at, const std::string& path, const std::string& name, int min, int max) {
    const double v = h5::read_attribute(at, path, name);
    if (!(v >= min && v <= max && v == std::floor(v)))
        throw InputError{"recording: " + path + "@" + name + " = " + std::to_string(v) +
                         " is not a whole number in " + std::to_string(min) + ".." + std::to_string(max)};
    return static_cast<int>(v);
}

/// The attribute "order" of one of `count` things.
std::size_t place(hid_t entry, const std::string& path, std::size_t count) {
    return static_cast<std::size_t>(whole(entry, path, "order", 0, static_cast<int>(count) - 1));
}

View read_view(hid_t entry, const std::string& camera) {
    const std::string path = "raw/" + camera;
    View view;
    view.camera = camera;
    view.mm_per_px = h5::read_attribute(entry, path, "mm_per_px");
    view.distance_mm = h5::read_attribute(entry, path, "distance_mm");
    view.along = {h5::read_attribute(entry, path, "along_x"), h5::read_attribute(entry, path, "along_y")};
    view.frame_rate_hz = h5::read_attribute(entry, path, "frame_rate_hz");
    view.exposure_s = h5::read_attribute(entry, path, "exposure_s");
    view.dac_triggered = whole(entry, path, "dac_triggered", 0, 1) != 0;
    view.trigger_delay_s = h5::read_attribute(entry, path, "trigger_delay_s");
    view.arrival_delay_s = h5::read_attribute(entry, path, "arrival_delay_s");
    const std::vector<std::string> names = h5::names_in(entry, path + "/targets");
    view.targets.resize(names.size());
    for (const std::string& name : names) {
        const std::string at = fmt::format("{}/targets/{}", path, name);
        Target& t = view.targets[place(entry, at, names.size())];
        if (!t.name.empty())
            throw InputError{"recording: " + at + "@order is that of \"" + t.name + "\" too"};
        t.name = name;
        t.kind = static_cast<TargetKind>(whole(entry, at, "kind", 0, static_cast<int>(TargetKind::patch)));
        t.polarity = static_cast<Polarity>(whole(entry, at, "polarity", 0, 1));
        t.diameter_mm = h5::read_attribute(entry, at, "diameter_mm");
        t.width_mm = h5::read_attribute(entry, at, "width_mm");
        t.pitch_mm = h5::read_attribute(entry, at, "pitch_mm");
        t.offset_mm = h5::read_attribute(entry, at, "offset_mm");
        for (std::size_t k = 0; k < 4; ++k)
            t.roi_px[k] = whole(entry, at, std::string{"roi_"} + "xywh"[k] + "_px", -100000, 100000);
    }
    return view;
}

AccelerometerInfo read_accelerometer(hid_t entry) {
    const std::string path = "raw/accelerometer";
    AccelerometerInfo a;
    a.name = h5::read_attribute_text(entry, path, "name");
    a.rate_hz = h5::read_attribute(entry, path, "rate_hz");
    a.first_sample_s = h5::read_attribute(entry, path, "first_sample_s");
    a.clock_uncertainty_s = h5::read_attribute(entry, path, "clock_uncertainty_s");
    for (std::size_t k = 0; k < 3; ++k) {
        const std::string axis(1, "xyz"[k]);
        a.offset_counts[k] = h5::read_attribute(entry, path, "offset_counts_" + axis);
        a.mps2_per_count[k] = h5::read_attribute(entry, path, "mps2_per_count_" + axis);
        a.shaker_axis[k] = h5::read_attribute(entry, path, "shaker_axis_" + axis);
    }
    return a;
}

template <class T>
void same_length(const std::vector<T>& a, std::size_t n, const std::string& path) {
    if (a.size() != n)
        throw InputError{"recording: " + path + " has " + std::to_string(a.size()) + " entries beside " +
                         std::to_string(n)};
}

HostTime host(std::int64_t ns) { return HostTime{std::chrono::nanoseconds{ns}}; }

}  // namespace

SessionReader::SessionReader(const std::filesystem::path& file) : opened_{std::make_unique<Opened>()} {
    opened_->file = h5::open_file(file);
    if (!h5::exists(opened_->file.get(), "entry"))
        throw InputError{file.string() + ": not a recording of shakerd: it has no group \"entry\""};
    opened_->entry = h5::open_group(opened_->file.get(), "entry");
    const hid_t e = opened_->entry.get();
    SessionHeader& header = opened_->header;
    header.title = h5::read_text(e, "title");
    header.kind = h5::read_text(e, "process/kind");
    header.config = h5::read_text(e, "process/config_text");
    header.rig = h5::read_text(e, "process/rig_text");
    header.frequency_hz = h5::read_attribute(e, "process", "frequency_hz");
    header.keep_frames = whole(e, "process", "keep_frames", 0, 1) != 0;
    header.ended_by_trip =
        h5::has_attribute(e, "process", "ended_by_trip") && whole(e, "process", "ended_by_trip", 0, 1) != 0;
    header.dac = {h5::read_attribute_text(e, "raw/drive", "name"),
                  h5::read_attribute(e, "raw/drive", "rate_hz"),
                  h5::read_attribute(e, "raw/drive", "full_scale_V")};
    header.accelerometer = read_accelerometer(e);
    header.views.resize(static_cast<std::size_t>(whole(e, "process", "cameras", 0, 64)));
    std::size_t cameras = 0;
    for (const std::string& name : h5::names_in(e, "raw")) {
        if (name == "drive" || name == "accelerometer") continue;
        View& view = header.views.at(place(e, "raw/" + name, header.views.size()));
        if (!view.camera.empty())
            throw InputError{"recording: raw/" + name + "@order is that of \"" + view.camera + "\" too"};
        view = read_view(e, name);
        ++cameras;
    }
    if (cameras != header.views.size())
        throw InputError{"recording: raw has " + std::to_string(cameras) + " cameras, process@cameras says " +
                         std::to_string(header.views.size())};
}

SessionReader::~SessionReader() = default;

const SessionHeader& SessionReader::header() const noexcept { return opened_->header; }

std::vector<PlayTime> SessionReader::play_times() const {
    const auto tick = h5::read<std::int64_t>(opened_->entry.get(), "raw/drive/play_tick");
    const auto heard = h5::read<std::int64_t>(opened_->entry.get(), "raw/drive/play_heard");
    const auto lost = h5::read<std::int64_t>(opened_->entry.get(), "raw/drive/play_lost");
    same_length(heard, tick.size(), "raw/drive/play_heard");
    same_length(lost, tick.size(), "raw/drive/play_lost");
    std::vector<PlayTime> out(tick.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = {{tick[i]}, host(heard[i]), lost[i]};
    return out;
}

std::vector<DriveChange> SessionReader::changes() const {
    const std::string g = "raw/drive/changes/";
    const auto first = h5::read<std::int64_t>(opened_->entry.get(), g + "first_tick");
    const auto ramp = h5::read<std::int64_t>(opened_->entry.get(), g + "ramp_samples");
    // Recordings made before there were stops have none.
    const auto stop = h5::exists(opened_->entry.get(), g + "stop_samples")
                          ? h5::read<std::int64_t>(opened_->entry.get(), g + "stop_samples")
                          : std::vector<std::int64_t>(first.size(), 0);
    const auto ramp_periods = h5::read<std::int64_t>(opened_->entry.get(), g + "ramp_periods");
    const auto phase = h5::read<std::uint64_t>(opened_->entry.get(), g + "phase");
    const auto phase_low = h5::read<std::uint64_t>(opened_->entry.get(), g + "phase_low");
    const auto step = h5::read<std::uint64_t>(opened_->entry.get(), g + "step");
    const auto step_low = h5::read<std::uint64_t>(opened_->entry.get(), g + "step_low");
    const auto sequence = h5::read<std::uint64_t>(opened_->entry.get(), g + "sequence");
    const auto frequency = h5::read<double>(opened_->entry.get(), g + "frequency");
    const auto re = h5::read<double>(opened_->entry.get(), g + "harmonics_re");
    const auto im = h5::read<double>(opened_->entry.get(), g + "harmonics_im");
    same_length(ramp, first.size(), g + "ramp_samples");
    same_length(stop, first.size(), g + "stop_samples");
    same_length(ramp_periods, first.size(), g + "ramp_periods");
    same_length(phase, first.size(), g + "phase");
    same_length(phase_low, first.size(), g + "phase_low");
    same_length(step, first.size(), g + "step");
    same_length(step_low, first.size(), g + "step_low");
    same_length(sequence, first.size(), g + "sequence");
    same_length(frequency, first.size(), g + "frequency");
    same_length(re, max_harmonics * first.size(), g + "harmonics_re");
    same_length(im, max_harmonics * first.size(), g + "harmonics_im");
    for (const std::int64_t n : ramp_periods)
        if (n < 1 || n > std::numeric_limits<int>::max())
            throw InputError{"recording: " + g + "ramp_periods " + std::to_string(n) + " is not 1 or more"};
    for (const std::int64_t n : stop)
        if (n < 0)
            throw InputError{"recording: " + g + "stop_samples " + std::to_string(n) + " is not 0 or more"};
    std::vector<DriveChange> out(first.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
        DriveChange& c = out[i];
        for (std::size_t k = 0; k < max_harmonics; ++k)
            c.command.volts.a[k] = {re[max_harmonics * i + k], im[max_harmonics * i + k]};
        c.command.frequency = frequency[i];
        c.command.ramp_periods = static_cast<int>(ramp_periods[i]);
        c.command.sequence = sequence[i];
        c.first = {first[i]};
        c.ramp = ramp[i];
        c.stop = stop[i];
        c.phase = turns_of(phase[i], phase_low[i]);
        c.step = turns_of(step[i], step_low[i]);
    }
    return out;
}

std::vector<std::string> SessionReader::names(const std::string& path) const {
    return h5::names_in(opened_->entry.get(), path);
}

std::vector<Column> SessionReader::table(const std::string& path) const {
    std::vector<Column> columns;
    for (const std::string& name : h5::names_in(opened_->entry.get(), path)) {
        const std::string at = fmt::format("{}/{}", path, name);
        columns.push_back({name, h5::read_attribute_text(opened_->entry.get(), at, "units"),
                           h5::read<double>(opened_->entry.get(), at)});
    }
    if (columns.empty()) throw InputError{"recording has no table \"" + path + "\""};
    return columns;
}

double SessionReader::scalar(const std::string& path) const {
    const auto values = h5::read<double>(opened_->entry.get(), path, 1);
    if (values.size() != 1) throw InputError{"recording: \"" + path + "\" is not one number"};
    return values.front();
}

std::string SessionReader::text(const std::string& path) const {
    return h5::read_text(opened_->entry.get(), path);
}

std::vector<double> SessionReader::numbers(const std::string& path) const {
    return h5::read<double>(opened_->entry.get(), path);
}

std::vector<std::string> SessionReader::texts(const std::string& path) const {
    return h5::read_texts(opened_->entry.get(), path);
}

bool SessionReader::has(const std::string& path) const { return h5::exists(opened_->entry.get(), path); }

}  // namespace shaker
