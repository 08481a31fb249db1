#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/written_file.hpp"
#include "drivers/recorded/nexus.hpp"
#include "drivers/recorded/recording_describe.hpp"
#include "drivers/recorded/recording_streams.hpp"

namespace shaker::recorded {

namespace {

// Chunks of a few seconds, but few enough that their index stays within a page of the disk for hours.
hsize_t chunk_rows(double rows_per_s) {
    constexpr double chunk_s = 4;
    constexpr hsize_t least = 512, most = 65536;
    hsize_t rows = least;
    while (rows < most && static_cast<double>(rows) < chunk_s * rows_per_s) rows *= 2;
    return rows;
}

hid_t type_of(RawColumn::Type type) {
    return with_zero(type, [](auto zero) { return h5::type_of<decltype(zero)>(); });
}

template <class Row>
void append(const std::vector<Numbered*>& to, std::span<const RawColumnOf<Row>> columns, const Row& row) {
    std::array<std::byte, max_harmonics * sizeof(double)> values;  // of the widest column
    for (std::size_t i = 0; i < columns.size(); ++i) {
        columns[i].get(row, values.data());
        to[i]->data.append_bytes(std::span{values}.first(columns[i].bytes()));
    }
}

constexpr double change_rate = 50;                           // drive changes per second, approximate maximum
constexpr const char* virtual_date = "1970-01-01T00:00:00";  // start of a run on virtual time

}  // namespace

Numbered* RecordingWriter::Streams::grow(const std::string& path, hid_t type, std::vector<hsize_t> row,
                                         double rows_per_s, const std::string& units, bool provisional) {
    columns.push_back(path);
    growing.push_back({{entry.get(), path, type, std::move(row), chunk_rows(rows_per_s), units},
                       columns.size() - 1,
                       provisional});
    by_path[path] = &growing.back();
    return &growing.back();
}

Numbered* RecordingWriter::Streams::grow(const RawColumn& column, double rows_per_s,
                                         const std::string& path) {
    std::vector<hsize_t> row;
    if (column.values > 1) row.push_back(column.values);
    return grow(path, type_of(column.type), std::move(row), rows_per_s, column.units);
}

template <class Row>
std::vector<Numbered*> RecordingWriter::Streams::grow(std::span<const RawColumnOf<Row>> row,
                                                      double rows_per_s, const std::string& camera) {
    std::vector<Numbered*> out;
    for (const auto& column : row) out.push_back(grow(column, rows_per_s, path_of(column, camera)));
    return out;
}

void RecordingWriter::Streams::open_drive(const DacInfo& dac) {
    const h5::Handle g = h5::make_group(entry.get(), raw::drive, "NXcollection");
    describe(g.get(), dac);
    const double rate = dac.rate_hz / static_cast<double>(std::max<std::size_t>(1, dac.block_frames));
    plays = grow<PlayTime>(raw::plays, rate);
    h5::make_group(entry.get(), raw::changes, "NXcollection");
    changes = grow<DriveChange>(raw::drive_changes, change_rate);
}

void RecordingWriter::Streams::open_accelerometer(const AccelerometerInfo& info) {
    const h5::Handle g = h5::make_group(entry.get(), raw::accelerometer, "NXcollection");
    describe(g.get(), info);
    counts = grow(raw::counts, info.rate_hz, path_of(raw::counts));
    blocks = grow<RawBlock>(raw::blocks, info.rate_hz / AccelBlock::capacity);
}

void RecordingWriter::Streams::open_camera(const View& view, std::int64_t order) {
    const std::string path = "raw/" + view.camera;
    const h5::Handle g = h5::make_group(entry.get(), path, "NXcollection");
    h5::set_attribute(g.get(), "order", order);
    describe(g.get(), view);
    cameras.push_back({.frames = grow<RawFrame>(raw::frames, view.frame_rate_hz, view.camera)});
    if (view.positions)
        cameras.back().sightings =
            grow(path_of(raw::sightings, view.camera), type_of(raw::sightings.type),
                 {view.targets.size(), raw::sighting_values}, view.frame_rate_hz, raw::sightings.units);
}

void RecordingWriter::Streams::open_once(const std::string& path, const Place& place) {
    const bool number = place.kind == Place::Kind::number;
    h5::Handle type = number ? h5::Handle{H5Tcopy(H5T_NATIVE_DOUBLE), path} : h5::text_type(place.text_bytes);
    h5::Handle set = h5::make_value(entry.get(), path, type.get());
    if (number) {
        const double unknown = std::numeric_limits<double>::quiet_NaN();
        h5::check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, &unknown), path);
        h5::set_attribute(set.get(), "units", place.units.empty() ? std::string{"1"} : place.units);
    }
    columns.push_back(path);
    once.emplace(path, Once{std::move(set), std::move(type), columns.size() - 1});
}

void RecordingWriter::Streams::open_group(const GroupLayout& layout) {
    if (!h5::exists(entry.get(), layout.path)) h5::make_group(entry.get(), layout.path, layout.nx_class);
    const h5::Handle group = h5::open_group(entry.get(), layout.path);
    for (const auto& [key, text] : layout.attributes) set_plot_attribute(group.get(), key, text);
    std::vector<Numbered*> table;
    for (const Place& p : layout.places) {
        const std::string path = fmt::format("{}/{}", layout.path, p.name);
        if (p.kind == Place::Kind::numbers) {
            table.push_back(grow(path, H5T_NATIVE_DOUBLE, {}, layout.rows_per_s, p.units, p.provisional));
        } else if (p.kind == Place::Kind::texts) {
            grow(path, h5::text_type(p.text_bytes).get(), {}, layout.rows_per_s, "");
        } else {
            open_once(path, p);
        }
    }
    table_of[layout.path] = tables.size();
    tables.push_back(std::move(table));
}

void RecordingWriter::Streams::begin(const RecordingHeader& header) {
    h5::set_attribute(file.get(), "NX_class", std::string{"NXroot"});
    h5::set_attribute(file.get(), "default", std::string{"entry"});
    h5::set_attribute(file.get(), "creator", std::string{"shakerd"});
    h5::set_attribute(file.get(), "creator_version", std::string{SHAKER_VERSION});
    entry = h5::make_group(file.get(), "entry", "NXentry");
    const hid_t e = entry.get();
    h5::write_text(e, "title", header.title);
    define_entry(e, header.groups);
    if (!header.started.empty()) {
        h5::write_text(e, "start_time", header.started);
        if (header.started.starts_with(virtual_date))
            h5::set_attribute(e, "time_reference",
                              std::string{"virtual time of a simulation: start_time stands for its first "
                                          "sample and is not a date"});
        open_once("end_time", {"end_time", "", Place::Kind::text, header.started.size()});
    }
    if (!header.identifier.empty()) h5::write_text(e, "experiment_identifier", header.identifier);
    const h5::Handle process = h5::make_group(e, "process", "NXprocess");
    describe_program(process.get(), header.config);
    h5::write_text(process.get(), "version", SHAKER_VERSION);
    h5::write_text(process.get(), "kind", header.kind);
    h5::write_text(process.get(), "rig_text", header.rig);
    if (!header.mixers.empty()) h5::write_text(process.get(), "mixers", header.mixers);
    h5::set_attribute(process.get(), "frequency_hz", header.frequency_hz);
    h5::set_attribute(process.get(), "pictures", std::string{recorded::name(header.pictures)});
    h5::set_attribute(process.get(), "cameras", static_cast<std::int64_t>(header.views.size()));
    h5::set_attribute(process.get(), "schema", std::int64_t{header.schema});
    for (const auto& [group, text] : {std::pair{"user", header.user}, std::pair{"sample", header.sample}}) {
        const h5::Handle g = h5::make_group(e, group, std::string{"NX"} + group);
        h5::write_text(g.get(), "name", text.empty() ? "not given" : text);
    }
}

RecordingWriter::~RecordingWriter() {
    if (streams_ && streams_->file.get() >= 0) h5::written_file(streams_->file.get())->leave();
}

RecordingWriter::RecordingWriter(const std::filesystem::path& file, const RecordingHeader& header)
    : streams_{std::make_unique<Streams>()} {
    Streams& s = *streams_;
    s.name = file.string();
    s.lock = h5::FileLock::of_new(file);
    s.file = h5::create_file(file);
    try {
        s.write_head(header);
    } catch (...) {  // it holds no data
        std::error_code ignored;
        std::filesystem::remove(file, ignored);
        h5::written_file(s.file.get())->leave();
        throw;
    }
}

void RecordingWriter::Streams::write_head(const RecordingHeader& header) {
    begin(header);
    open_drive(header.dac);
    open_accelerometer(header.accelerometer);
    for (std::size_t k = 0; k < header.views.size(); ++k)
        open_camera(header.views[k], static_cast<std::int64_t>(k));
    for (const GroupLayout& g : header.groups) open_group(g);
    link_sensors(entry.get());
    seals.emplace(entry.get(), columns);
    h5::let_others_read(file.get(), name);
}

RecordingWriter::RecordingWriter(std::unique_ptr<Streams> streams) : streams_{std::move(streams)} {}
RecordingWriter::RecordingWriter(RecordingWriter&&) noexcept = default;
RecordingWriter& RecordingWriter::operator=(RecordingWriter&&) noexcept = default;

RecordingWriter RecordingWriter::mend(const std::filesystem::path& copy) {
    auto streams = std::make_unique<Streams>();
    streams->name = copy.string();
    streams->file = h5::open_to_mend(copy);
    if (!h5::exists(streams->file.get(), "entry"))
        throw InputError{copy.string() + ": holds no data: the recording ended before its head was written"};
    streams->entry = h5::open_group(streams->file.get(), "entry");
    streams->mend();
    return RecordingWriter{std::move(streams)};
}

void RecordingWriter::add(const PlayTime& played) { append<PlayTime>(streams_->plays, raw::plays, played); }

void RecordingWriter::add(const DriveChange& change) {
    append<DriveChange>(streams_->changes, raw::drive_changes, change);
}

void RecordingWriter::add(const AccelBlock& block) {
    append<RawBlock>(streams_->blocks, raw::blocks,
                     {block.first, block.arrived, block.quality, static_cast<std::uint8_t>(block.size)});
    streams_->counts->data.append(
        std::span<const std::int32_t>{block.counts.front().data(), 3 * static_cast<std::size_t>(block.size)});
}

void RecordingWriter::add(std::size_t camera, const Frame& frame, std::uint64_t picture) {
    const Streams::CameraStream& c = streams_->cameras.at(camera);
    append<RawFrame>(c.frames, raw::frames,
                     {frame.tick, frame.arrived, frame.stamp, frame.mid_exposure, frame.quality, picture});
    for (const Sighting& s : frame.sightings)
        for (const double value : {s.x_px, s.y_px, s.sd_px}) c.sightings->data.append(value);
}

Numbered& RecordingWriter::Streams::column(const std::string& path) {
    const auto it = by_path.find(path);
    if (it == by_path.end())
        throw DeviceError{name + ": there is no place for the column \"" + path +
                          "\" in the layout of this recording"};
    return *it->second;
}

std::size_t RecordingWriter::table(const std::string& path) const {
    const auto it = streams_->table_of.find(path);
    if (it == streams_->table_of.end())
        throw DeviceError{streams_->name + ": there is no place for \"" + path +
                          "\" in the layout of this recording"};
    return it->second;
}

void RecordingWriter::row(std::size_t table, std::span<const double> values) {
    const std::vector<Numbered*>& columns = streams_->tables.at(table);
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i]->data.append(values[i]);
}

void RecordingWriter::rows(const std::string& path, const std::vector<Column>& columns) {
    for (const Column& c : columns)
        streams_->column(path + "/" + c.name).data.append(std::span<const double>{c.values});
}

void RecordingWriter::texts(const std::string& path, const std::vector<std::string>& texts) {
    for (const std::string& t : texts) streams_->column(path).data.append_text(t);
}

void RecordingWriter::replace(const std::string& path, const std::vector<double>& values) {
    Numbered& column = streams_->column(path);
    column.data.flush();
    column.data.replace(std::as_bytes(std::span{values}));
}

void RecordingWriter::replace_pictures(const std::string& camera,
                                       const std::vector<std::uint64_t>& pictures) {
    streams_->column(path_of(raw::picture, camera)).data.replace(std::as_bytes(std::span{pictures}));
}

bool RecordingWriter::has(const std::string& path) const { return streams_->by_path.contains(path); }

void RecordingWriter::clear(const std::string& path) {
    for (const auto& [name, column] : streams_->by_path)
        if (name.starts_with(path + "/")) column->data.clear();
}

void RecordingWriter::Streams::write_once(const std::string& path, std::span<const std::byte> value) {
    const auto it = once.find(path);
    if (it == once.end())
        throw DeviceError{name + ": there is no place for \"" + path + "\" in the layout of this recording"};
    it->second.write(value, path);
}

void RecordingWriter::scalar(const std::string& path, double value) {
    streams_->write_once(path, std::as_bytes(std::span{&value, 1}));
}

void RecordingWriter::text(const std::string& path, const std::string& text) {
    const auto it = streams_->once.find(path);
    std::string padded = text;
    if (it != streams_->once.end()) padded.resize(H5Tget_size(it->second.type.get()), '\0');
    streams_->write_once(path, std::as_bytes(std::span{padded}));
}

void RecordingWriter::flush() {
    for (Numbered& n : streams_->growing) {
        n.data.flush();
        const std::int64_t checksum{n.data.take_checksum()};
        streams_->seals->add(n.column, n.data.rows(), n.provisional ? h5::SealEntry::unchecked : checksum);
    }
    for (const auto& [path, o] : streams_->once) streams_->seals->add(o.column, o.written, o.checksum);
    streams_->seals->flush();
    h5::flush(streams_->file.get(), streams_->name);
}

void RecordingWriter::sync() { h5::sync(streams_->file.get(), streams_->name); }

void RecordingWriter::close() {
    flush();
    sync();
    std::unique_ptr<Streams> last = std::move(streams_);
    streams_ = std::make_unique<Streams>();
    streams_->lock = std::move(last->lock);
    const std::string file = last->name;
    h5::Handle handle = std::move(last->file);
    last.reset();
    h5::close_file(std::move(handle), file);
}

}  // namespace shaker::recorded
