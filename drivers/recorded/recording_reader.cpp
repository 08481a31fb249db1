#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/seals.hpp"
#include "drivers/recorded/opened_recording.hpp"
#include "drivers/recorded/recording_describe.hpp"

namespace shaker::recorded {

std::string_view name(KeptPictures kept) noexcept {
    return kept_pictures_words[static_cast<std::size_t>(kept)];
}

std::optional<KeptPictures> kept_pictures_named(std::string_view word) noexcept {
    const auto at = std::ranges::find(kept_pictures_words, word);
    if (at == kept_pictures_words.end()) return std::nullopt;
    return static_cast<KeptPictures>(at - kept_pictures_words.begin());
}

std::int64_t first_second_frames(const View& view) noexcept {
    return std::max<std::int64_t>(1, std::llround(view.frame_rate_hz));
}

std::filesystem::path pictures_folder(std::filesystem::path recording) {
    if (recording.extension() == ".part") recording.replace_extension();
    return recording.replace_extension(".frames");
}

RecordingReader::RecordingReader(const std::filesystem::path& file, Open open)
    : opened_{std::make_unique<Opened>()} {
    opened_->path = file;
    opened_->file = h5::open_file(file, open == Open::growing ? h5::Access::growing : h5::Access::finished);
    if (!h5::exists(opened_->file.get(), "entry"))
        throw InputError{file.string() + ": not a recording of shakerd: it has no group \"entry\""};
    opened_->entry = h5::open_group(opened_->file.get(), "entry");
    const hid_t e = opened_->entry.get();
    if (!h5::exists(e, "raw"))
        throw InputError{file.string() + ": not a recording: it has no group \"entry/raw\"" +
                         (h5::exists(e, "passes") ? "; the points of a campaign are read by export, mu and "
                                                    "report, and made again by campaign --reduce FOLDER"
                                                  : "")};
    RecordingHeader& header = opened_->header;
    header.title = h5::read_text(e, "title");
    if (h5::exists(e, "start_time")) header.started = h5::read_text(e, "start_time");
    if (h5::exists(e, "experiment_identifier")) header.identifier = h5::read_text(e, "experiment_identifier");
    header.kind = h5::read_text(e, "process/kind");
    header.config = h5::read_text(e, "process/config_text");
    header.rig = h5::read_text(e, "process/rig_text");
    if (h5::exists(e, "process/mixers")) header.mixers = h5::read_text(e, "process/mixers");
    header.user = h5::read_text(e, "user/name");
    header.sample = h5::read_text(e, "sample/name");
    header.frequency_hz = h5::read_attribute(e, "process", "frequency_hz");
    const std::string pictures = h5::read_attribute_text(e, "process", "pictures");
    const auto kept = kept_pictures_named(pictures);
    if (!kept)
        throw InputError{fmt::format("recording: process@pictures \"{}\" is not one of {}", pictures,
                                     fmt::join(kept_pictures_words, ", "))};
    header.pictures = *kept;
    if (h5::has_attribute(e, "process", "schema"))
        header.schema = whole_attribute(e, "process", "schema", 1, std::numeric_limits<int>::max());
    header.dac = read_dac(e, raw::drive);
    header.accelerometer = read_accelerometer(e, raw::accelerometer);
    header.views.resize(static_cast<std::size_t>(whole_attribute(e, "process", "cameras", 0, 64)));
    std::size_t cameras = 0;
    for (const std::string& name : h5::names_in(e, "raw")) {
        if (name == "drive" || name == "accelerometer") continue;
        View& view = header.views.at(place_of(e, "raw/" + name, header.views.size()));
        if (!view.camera.empty())
            throw InputError{"recording: raw/" + name + "@order is used by \"" + view.camera + "\" too"};
        view = read_view(e, name);
        ++cameras;
    }
    if (cameras != header.views.size())
        throw InputError{"recording: raw has " + std::to_string(cameras) + " cameras, process@cameras says " +
                         std::to_string(header.views.size())};
}

RecordingReader::~RecordingReader() = default;

const RecordingHeader& RecordingReader::header() const noexcept { return opened_->header; }

std::vector<PlayTime> RecordingReader::play_times() const {
    return read_rows<PlayTime>(opened_->entry.get(), raw::plays);
}

std::vector<DriveChange> RecordingReader::changes() const {
    return read_rows<DriveChange>(opened_->entry.get(), raw::drive_changes);
}

std::vector<std::string> RecordingReader::names(const std::string& path) const {
    return h5::names_in(opened_->entry.get(), path);
}

std::vector<Column> RecordingReader::table(const std::string& path) const {
    const hid_t e = opened_->entry.get();
    std::vector<Column> columns;
    for (const std::string& name : h5::names_in(e, path)) {
        const std::string at = fmt::format("{}/{}", path, name);
        if (!h5::has_attribute(e, at, "units") || h5::description_of(e, at).shape.size() != 1) continue;
        columns.push_back({name, h5::read_attribute_text(e, at, "units"), h5::read<double>(e, at)});
    }
    if (columns.empty()) throw InputError{"recording has no table \"" + path + "\""};
    return columns;
}

double RecordingReader::scalar(const std::string& path) const {
    const auto values = h5::read<double>(opened_->entry.get(), path, 1);
    if (values.size() != 1) throw InputError{"recording: \"" + path + "\" is not one number"};
    return values.front();
}

std::string RecordingReader::text(const std::string& path) const {
    return h5::read_text(opened_->entry.get(), path);
}

std::vector<double> RecordingReader::numbers(const std::string& path) const {
    return h5::read<double>(opened_->entry.get(), path);
}

std::vector<std::string> RecordingReader::texts(const std::string& path) const {
    return h5::read_texts(opened_->entry.get(), path);
}

std::vector<std::string> RecordingReader::damage() const {
    const hid_t e = opened_->entry.get();
    std::vector<std::string> found;
    for (const h5::SealedColumn& column : h5::read_seals(e)) {
        const hsize_t sealed = column.pieces.empty() ? 0 : column.pieces.back().to;
        const h5::Bytes bytes = h5::read_bytes(e, column.path);
        const hsize_t good = column.good_rows(bytes.values, bytes.row);
        const bool once = h5::description_of(e, column.path).shape.empty();
        if (good != sealed)
            found.push_back(fmt::format("{}: damaged from row {} on", column.path, good));
        else if (!once && bytes.values.size() != sealed * bytes.row)
            found.push_back(
                fmt::format("{}: rows from {} on are not covered by a seal", column.path, sealed));
    }
    return found;
}

std::vector<RawFrame> RecordingReader::frame_rows(const std::string& camera) const {
    return read_rows<RawFrame>(opened_->entry.get(), raw::frames, camera);
}

std::vector<Frame> RecordingReader::frames(const std::string& camera) const {
    const hid_t e = opened_->entry.get();
    const std::vector<RawFrame> rows = frame_rows(camera);
    std::vector<Frame> frames(rows.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const RawFrame& row = rows[i];
        frames[i].tick = row.tick;
        frames[i].arrived = row.arrived;
        frames[i].stamp = row.stamp;
        frames[i].mid_exposure = row.mid_exposure;
        frames[i].quality = row.quality;
    }
    const std::string path = path_of(raw::sightings, camera);
    if (!h5::exists(e, path) || frames.empty()) return frames;
    const auto values = h5::read<double>(e, path);
    const std::size_t targets = values.size() / raw::sighting_values / frames.size();
    require_length(values.size(), frames.size() * targets * raw::sighting_values, path);
    auto value = values.begin();
    for (Frame& frame : frames)
        for (std::size_t k = 0; k < targets; ++k, value += raw::sighting_values)
            frame.sightings.push_back({value[0], value[1], value[2]});
    return frames;
}

std::vector<std::uint64_t> RecordingReader::pictures_of(const std::string& camera) const {
    return h5::read<std::uint64_t>(opened_->entry.get(), path_of(raw::picture, camera));
}

std::uint64_t RecordingReader::frames_without_picture() const {
    std::uint64_t without = 0;
    for (const View& view : opened_->header.views) {
        if (view.positions) continue;
        const std::vector<std::uint64_t> pictures = pictures_of(view.camera);
        without += static_cast<std::uint64_t>(std::ranges::count(pictures, std::uint64_t{0}));
    }
    return without;
}

const std::filesystem::path& RecordingReader::file() const noexcept { return opened_->path; }

bool RecordingReader::has(const std::string& path) const { return h5::exists(opened_->entry.get(), path); }

}  // namespace shaker::recorded
