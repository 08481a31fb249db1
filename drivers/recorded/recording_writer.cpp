#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

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
    switch (type) {
        case RawColumn::Type::int32:
            return H5T_NATIVE_INT32;
        case RawColumn::Type::int64:
            return H5T_NATIVE_INT64;
        case RawColumn::Type::uint8:
            return H5T_NATIVE_UINT8;
        case RawColumn::Type::uint64:
            return H5T_NATIVE_UINT64;
        case RawColumn::Type::float64:
            return H5T_NATIVE_DOUBLE;
    }
    return H5T_NATIVE_DOUBLE;
}

constexpr double change_rate = 50;                           // drive changes per second, approximate maximum
constexpr const char* virtual_date = "1970-01-01T00:00:00";  // start of a run on virtual time

double time_of(const Frame& frame) {
    return frame.mid_exposure ? seconds(*frame.mid_exposure) : std::numeric_limits<double>::quiet_NaN();
}

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
    return grow(path.empty() ? path_of(column) : path, type_of(column.type), std::move(row), rows_per_s,
                column.units);
}

void RecordingWriter::Streams::open_drive(const DacInfo& dac) {
    const h5::Handle g = h5::make_group(entry.get(), raw::drive, "NXcollection");
    describe(g.get(), dac);
    const double rate = dac.rate_hz / static_cast<double>(std::max<std::size_t>(1, dac.block_frames));
    play_tick = grow(raw::play_tick, rate);
    play_heard = grow(raw::play_heard, rate);
    play_lost = grow(raw::play_lost, rate);
    h5::make_group(entry.get(), raw::changes, "NXcollection");
    const auto of_change = [&](const RawColumn& column) { return grow(column, change_rate); };
    change = {.first = of_change(raw::first_tick),
              .ramp = of_change(raw::ramp_samples),
              .stop = of_change(raw::stop_samples),
              .taken_back = of_change(raw::taken_back),
              .ramp_periods = of_change(raw::ramp_periods),
              .phase = of_change(raw::phase),
              .phase_low = of_change(raw::phase_low),
              .step = of_change(raw::step),
              .step_low = of_change(raw::step_low),
              .sequence = of_change(raw::sequence),
              .frequency = of_change(raw::frequency),
              .re = of_change(raw::harmonics_re),
              .im = of_change(raw::harmonics_im)};
}

void RecordingWriter::Streams::open_accelerometer(const AccelerometerInfo& info) {
    const h5::Handle g = h5::make_group(entry.get(), raw::accelerometer, "NXcollection");
    describe(g.get(), info);
    const double blocks = info.rate_hz / AccelBlock::capacity;
    counts = grow(raw::counts, info.rate_hz);
    block_first = grow(raw::block_first, blocks);
    block_arrived = grow(raw::block_arrived, blocks);
    block_quality = grow(raw::block_quality, blocks);
    block_size = grow(raw::block_size, blocks);
}

void RecordingWriter::Streams::open_camera(const View& view, std::int64_t order) {
    const std::string path = "raw/" + view.camera;
    const h5::Handle g = h5::make_group(entry.get(), path, "NXcollection");
    h5::set_attribute(g.get(), "order", order);
    describe(g.get(), view);
    const auto column = [&](const RawColumn& of_frames) {
        return grow(of_frames, view.frame_rate_hz, path_of(of_frames, view.camera));
    };
    cameras.push_back({.tick = column(raw::tick),
                       .arrived = column(raw::arrived),
                       .stamp = column(raw::stamp),
                       .mid_exposure = column(raw::mid_exposure),
                       .quality = column(raw::quality),
                       .picture = column(raw::picture)});
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

void RecordingWriter::add(const PlayTime& played) {
    streams_->play_tick->data.append(played.tick.n);
    streams_->play_heard->data.append(std::int64_t{played.heard.time_since_epoch().count()});
    streams_->play_lost->data.append(played.lost);
}

void RecordingWriter::add(const DriveChange& c) {
    const auto& to = streams_->change;
    to.first->data.append(c.first.n);
    to.ramp->data.append(c.ramp);
    to.stop->data.append(c.stop);
    to.taken_back->data.append(c.taken_back);
    to.ramp_periods->data.append(std::int64_t{c.command.ramp_periods});
    to.phase->data.append(high_word(c.phase));
    to.phase_low->data.append(low_word(c.phase));
    to.step->data.append(high_word(c.step));
    to.step_low->data.append(low_word(c.step));
    to.sequence->data.append(c.command.sequence);
    to.frequency->data.append(c.command.frequency);
    for (const std::complex<double>& a : c.command.volts.a) {
        to.re->data.append(a.real());
        to.im->data.append(a.imag());
    }
}

void RecordingWriter::add(const AccelBlock& block) {
    streams_->block_first->data.append(block.first.n);
    streams_->block_arrived->data.append(std::int64_t{block.arrived.time_since_epoch().count()});
    streams_->block_quality->data.append(static_cast<std::uint8_t>(block.quality));
    streams_->block_size->data.append(static_cast<std::uint8_t>(block.size));
    streams_->counts->data.append(
        std::span<const std::int32_t>{block.counts.front().data(), 3 * static_cast<std::size_t>(block.size)});
}

void RecordingWriter::add(std::size_t camera, const Frame& frame, std::uint64_t picture) {
    const Streams::CameraStream& c = streams_->cameras.at(camera);
    c.tick->data.append(frame.tick.n);
    c.arrived->data.append(std::int64_t{frame.arrived.time_since_epoch().count()});
    c.stamp->data.append(frame.stamp ? frame.stamp->n : pictures::no_stamp);
    c.mid_exposure->data.append(time_of(frame));
    c.quality->data.append(static_cast<std::uint8_t>(frame.quality));
    c.picture->data.append(picture);
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
