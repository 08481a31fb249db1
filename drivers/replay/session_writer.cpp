#include <spdlog/fmt/fmt.h>

#include <list>
#include <optional>

#include "drivers/errors.hpp"
#include "drivers/replay/h5.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

namespace {

constexpr hsize_t stamp_chunk = 1024;

void describe(hid_t group, const DacInfo& dac) {
    h5::set_attribute(group, "name", dac.name);
    h5::set_attribute(group, "rate_hz", dac.rate_hz);
    h5::set_attribute(group, "full_scale_V", dac.full_scale_V);
}

void describe(hid_t group, const AccelerometerInfo& a) {
    h5::set_attribute(group, "name", a.name);
    h5::set_attribute(group, "rate_hz", a.rate_hz);
    h5::set_attribute(group, "first_sample_s", a.first_sample_s);
    h5::set_attribute(group, "clock_uncertainty_s", a.clock_uncertainty_s);
    for (std::size_t k = 0; k < 3; ++k) {
        h5::set_attribute(group, fmt::format("offset_counts_{}", "xyz"[k]), a.offset_counts[k]);
        h5::set_attribute(group, fmt::format("mps2_per_count_{}", "xyz"[k]), a.mps2_per_count[k]);
        h5::set_attribute(group, fmt::format("shaker_axis_{}", "xyz"[k]), a.shaker_axis[k]);
    }
}

void describe(hid_t group, const View& view) {
    h5::set_attribute(group, "mm_per_px", view.mm_per_px);
    h5::set_attribute(group, "distance_mm", view.distance_mm);
    h5::set_attribute(group, "along_x", view.along[0]);
    h5::set_attribute(group, "along_y", view.along[1]);
    h5::set_attribute(group, "frame_rate_hz", view.frame_rate_hz);
    h5::set_attribute(group, "exposure_s", view.exposure_s);
    h5::set_attribute(group, "dac_triggered", std::int64_t{view.dac_triggered});
    h5::set_attribute(group, "trigger_delay_s", view.trigger_delay_s);
    h5::set_attribute(group, "arrival_delay_s", view.arrival_delay_s);
    std::int64_t order = 0;
    for (const Target& t : view.targets) {
        const h5::Handle g = h5::make_group(group, "targets/" + t.name, "NXcollection");
        h5::set_attribute(g.get(), "order", order++);
        h5::set_attribute(g.get(), "kind", std::int64_t{static_cast<int>(t.kind)});
        h5::set_attribute(g.get(), "polarity", std::int64_t{static_cast<int>(t.polarity)});
        h5::set_attribute(g.get(), "diameter_mm", t.diameter_mm);
        h5::set_attribute(g.get(), "width_mm", t.width_mm);
        h5::set_attribute(g.get(), "pitch_mm", t.pitch_mm);
        h5::set_attribute(g.get(), "offset_mm", t.offset_mm);
        for (std::size_t k = 0; k < 4; ++k)
            h5::set_attribute(g.get(), fmt::format("roi_{}_px", "xywh"[k]), std::int64_t{t.roi_px[k]});
    }
}

double time_of(const Frame& frame) {
    return frame.mid_exposure ? seconds(*frame.mid_exposure) : std::numeric_limits<double>::quiet_NaN();
}

// The data set "frames" of a group, made with the first of them: only then their size is known.
class Pictures {
public:
    void append(hid_t group, std::size_t camera, const Frame& frame) {
        const std::array<int, 3> size{frame.width, frame.height, frame.bytes_per_pixel};
        if (size_ == std::array<int, 3>{}) begin(group, size);
        if (size_ != size)
            throw DeviceError{
                fmt::format("camera {}: a frame of {} x {} pixels of {} bytes after frames of {} x {} of {}",
                            camera, size[0], size[1], size[2], size_[0], size_[1], size_[2])};
        const std::byte* pixels = frame.pixels.data();
        if (frame.bytes_per_pixel == 1)
            pixels8_.append({reinterpret_cast<const std::uint8_t*>(pixels), frame.pixels.size()});
        else
            pixels16_.append({reinterpret_cast<const std::uint16_t*>(pixels), frame.pixels.size() / 2});
    }
    void flush() {
        pixels8_.flush();
        pixels16_.flush();
    }

private:
    void begin(hid_t group, const std::array<int, 3>& size) {
        size_ = size;
        const std::vector<hsize_t> row{static_cast<hsize_t>(size[1]), static_cast<hsize_t>(size[0])};
        if (size[2] == 1)
            pixels8_ = {group, "frames", row, 1, "count"};
        else
            pixels16_ = {group, "frames", row, 1, "count"};
    }
    std::array<int, 3> size_{};  // width, height, bytes a pixel; 0 before the first frame
    h5::Appender<std::uint8_t> pixels8_;
    h5::Appender<std::uint16_t> pixels16_;
};

}  // namespace

struct SessionWriter::Streams {
    struct Tail {
        h5::Handle group;
        Pictures pictures;
        h5::Appender<std::int64_t> tick;
        h5::Appender<double> mid_exposure;
    };
    struct CameraStream {
        h5::Handle group;
        Pictures pictures;
        h5::Appender<std::int64_t> tick, arrived, stamp;
        h5::Appender<double> mid_exposure;
        h5::Appender<std::uint8_t> quality;
        std::optional<Tail> tail;
    };
    h5::Handle file, entry;
    bool keep_frames = true;
    h5::Appender<std::int64_t> play_tick, play_heard, play_lost;
    std::vector<DriveChange> changes;
    h5::Appender<std::int32_t> counts;
    h5::Appender<std::int64_t> block_first, block_arrived;
    h5::Appender<std::uint8_t> block_quality, block_size;
    std::list<CameraStream> cameras;

    void open_drive(const DacInfo& dac);
    void open_accelerometer(const AccelerometerInfo& info);
    void open_camera(const View& view, std::int64_t order);
    void write_changes();
    /// The group that `path` lies in.
    void make_room(const std::string& path);
};

void SessionWriter::Streams::open_drive(const DacInfo& dac) {
    const h5::Handle g = h5::make_group(entry.get(), "raw/drive", "NXcollection");
    describe(g.get(), dac);
    play_tick = {g.get(), "play_tick", {}, stamp_chunk, "1"};
    play_heard = {g.get(), "play_heard", {}, stamp_chunk, "ns"};
    play_lost = {g.get(), "play_lost", {}, stamp_chunk, "1"};
}

void SessionWriter::Streams::open_accelerometer(const AccelerometerInfo& info) {
    const h5::Handle g = h5::make_group(entry.get(), "raw/accelerometer", "NXcollection");
    describe(g.get(), info);
    counts = {g.get(), "counts", {3}, 4096, "count"};
    block_first = {g.get(), "block_first", {}, stamp_chunk, "1"};
    block_arrived = {g.get(), "block_arrived", {}, stamp_chunk, "ns"};
    block_quality = {g.get(), "block_quality", {}, stamp_chunk, "1"};
    block_size = {g.get(), "block_size", {}, stamp_chunk, "1"};
}

void SessionWriter::Streams::open_camera(const View& view, std::int64_t order) {
    CameraStream& c = cameras.emplace_back();
    c.group = h5::make_group(entry.get(), "raw/" + view.camera, "NXcollection");
    h5::set_attribute(c.group.get(), "order", order);
    describe(c.group.get(), view);
    c.tick = {c.group.get(), "tick", {}, stamp_chunk, "1"};
    c.arrived = {c.group.get(), "arrived", {}, stamp_chunk, "ns"};
    c.stamp = {c.group.get(), "stamp", {}, stamp_chunk, "ns"};
    c.mid_exposure = {c.group.get(), "mid_exposure", {}, stamp_chunk, "s"};
    c.quality = {c.group.get(), "quality", {}, stamp_chunk, "1"};
}

SessionWriter::~SessionWriter() = default;

SessionWriter::SessionWriter(const std::filesystem::path& file, const SessionHeader& header)
    : streams_{std::make_unique<Streams>()} {
    Streams& s = *streams_;
    s.file = h5::create_file(file);
    s.keep_frames = header.keep_frames;
    h5::set_attribute(streams_->file.get(), "NX_class", std::string{"NXroot"});
    h5::set_attribute(streams_->file.get(), "default", std::string{"entry"});
    h5::set_attribute(streams_->file.get(), "creator", std::string{"shakerd"});
    streams_->entry = h5::make_group(streams_->file.get(), "entry", "NXentry");
    h5::write_text(streams_->entry.get(), "title", header.title);
    const h5::Handle process = h5::make_group(streams_->entry.get(), "process", "NXprocess");
    h5::write_text(process.get(), "program", "shakerd");
    h5::write_text(process.get(), "version", SHAKER_VERSION);
    h5::write_text(process.get(), "kind", header.kind);
    h5::write_text(process.get(), "config_text", header.config);
    h5::write_text(process.get(), "rig_text", header.rig);
    h5::set_attribute(process.get(), "frequency_hz", header.frequency_hz);
    h5::set_attribute(process.get(), "keep_frames", std::int64_t{header.keep_frames});

    h5::set_attribute(process.get(), "cameras", static_cast<std::int64_t>(header.views.size()));
    s.open_drive(header.dac);
    s.open_accelerometer(header.accelerometer);
    for (std::size_t k = 0; k < header.views.size(); ++k)
        s.open_camera(header.views[k], static_cast<std::int64_t>(k));
}

void SessionWriter::add(const PlayTime& played) {
    streams_->play_tick.append(played.tick.n);
    streams_->play_heard.append(played.heard.time_since_epoch().count());
    streams_->play_lost.append(played.lost);
}

void SessionWriter::add(const DriveChange& change) { streams_->changes.push_back(change); }

void SessionWriter::add(const AccelBlock& block) {
    streams_->block_first.append(block.first.n);
    streams_->block_arrived.append(block.arrived.time_since_epoch().count());
    streams_->block_quality.append(static_cast<std::uint8_t>(block.quality));
    streams_->block_size.append(static_cast<std::uint8_t>(block.size));
    streams_->counts.append({block.counts.front().data(), 3 * static_cast<std::size_t>(block.size)});
}

void SessionWriter::add(std::size_t camera, const Frame& frame) {
    auto c = std::next(streams_->cameras.begin(), static_cast<std::ptrdiff_t>(camera));
    if (streams_->keep_frames) c->pictures.append(c->group.get(), camera, frame);
    c->tick.append(frame.tick.n);
    c->arrived.append(frame.arrived.time_since_epoch().count());
    c->stamp.append(frame.stamp ? frame.stamp->n : no_stamp);
    c->mid_exposure.append(time_of(frame));
    c->quality.append(static_cast<std::uint8_t>(frame.quality));
}

void SessionWriter::tail(std::size_t camera, const Frame& frame) {
    auto c = std::next(streams_->cameras.begin(), static_cast<std::ptrdiff_t>(camera));
    if (!c->tail) {
        Streams::Tail& t = c->tail.emplace();
        t.group = h5::make_group(c->group.get(), "tail", "NXcollection");
        t.tick = {t.group.get(), "tick", {}, stamp_chunk, "1"};
        t.mid_exposure = {t.group.get(), "mid_exposure", {}, stamp_chunk, "s"};
    }
    c->tail->pictures.append(c->tail->group.get(), camera, frame);
    c->tail->tick.append(frame.tick.n);
    c->tail->mid_exposure.append(time_of(frame));
}

void SessionWriter::table(const std::string& path, const std::vector<Column>& columns,
                          const std::string& nx_class, const std::map<std::string, std::string>& attributes) {
    const h5::Handle group = h5::make_group(streams_->entry.get(), path, nx_class);
    for (const auto& [name, text] : attributes) h5::set_attribute(group.get(), name, text);
    for (const Column& c : columns)
        h5::write<double>(group.get(), c.name, c.values, {c.values.size()}, c.units);
}

void SessionWriter::Streams::make_room(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    if (slash != std::string::npos && !h5::exists(entry.get(), path.substr(0, slash)))
        h5::make_group(entry.get(), path.substr(0, slash), "NXcollection");
}

void SessionWriter::scalar(const std::string& path, double value, const std::string& units) {
    streams_->make_room(path);
    h5::write<double>(streams_->entry.get(), path, {&value, 1}, {}, units);
}

void SessionWriter::text(const std::string& path, const std::string& text) {
    streams_->make_room(path);
    h5::write_text(streams_->entry.get(), path, text);
}

void SessionWriter::texts(const std::string& path, const std::vector<std::string>& texts) {
    streams_->make_room(path);
    h5::write_texts(streams_->entry.get(), path, texts);
}

void SessionWriter::end_by_trip() {
    const h5::Handle process = h5::open_group(streams_->entry.get(), "process");
    h5::set_attribute(process.get(), "ended_by_trip", std::int64_t{1});
}

void SessionWriter::show(const std::string& path) {
    h5::set_attribute(streams_->entry.get(), "default", path);
}

void SessionWriter::Streams::write_changes() {
    std::vector<std::int64_t> first, ramp, stop, ramp_periods;
    std::vector<std::uint64_t> phase, phase_low, step, step_low, sequence;
    std::vector<double> re, im, frequency;
    for (const DriveChange& c : changes) {
        first.push_back(c.first.n);
        ramp.push_back(c.ramp);
        stop.push_back(c.stop);
        ramp_periods.push_back(c.command.ramp_periods);
        phase.push_back(high_word(c.phase));
        phase_low.push_back(low_word(c.phase));
        step.push_back(high_word(c.step));
        step_low.push_back(low_word(c.step));
        sequence.push_back(c.command.sequence);
        frequency.push_back(c.command.frequency);
        for (const std::complex<double>& a : c.command.volts.a) {
            re.push_back(a.real());
            im.push_back(a.imag());
        }
    }
    const hsize_t n = changes.size();
    const h5::Handle g = h5::make_group(entry.get(), "raw/drive/changes", "NXcollection");
    h5::write<std::int64_t>(g.get(), "first_tick", first, {n}, "1");
    h5::write<std::int64_t>(g.get(), "ramp_samples", ramp, {n}, "1");
    h5::write<std::int64_t>(g.get(), "stop_samples", stop, {n}, "1");
    h5::write<std::int64_t>(g.get(), "ramp_periods", ramp_periods, {n}, "1");
    h5::write<std::uint64_t>(g.get(), "phase", phase, {n}, "1");
    h5::write<std::uint64_t>(g.get(), "phase_low", phase_low, {n}, "1");
    h5::write<std::uint64_t>(g.get(), "step", step, {n}, "1");
    h5::write<std::uint64_t>(g.get(), "step_low", step_low, {n}, "1");
    h5::write<std::uint64_t>(g.get(), "sequence", sequence, {n}, "1");
    h5::write<double>(g.get(), "frequency", frequency, {n}, "Hz");
    h5::write<double>(g.get(), "harmonics_re", re, {n, max_harmonics}, "V");
    h5::write<double>(g.get(), "harmonics_im", im, {n, max_harmonics}, "V");
}

void SessionWriter::flush() {
    streams_->write_changes();
    for (auto* a : {&streams_->play_tick, &streams_->play_heard, &streams_->play_lost, &streams_->block_first,
                    &streams_->block_arrived})
        a->flush();
    streams_->counts.flush();
    streams_->block_quality.flush();
    streams_->block_size.flush();
    for (Streams::CameraStream& c : streams_->cameras) {
        c.tick.flush();
        c.arrived.flush();
        c.stamp.flush();
        c.mid_exposure.flush();
        c.quality.flush();
        c.pictures.flush();
        if (!c.tail) continue;
        c.tail->pictures.flush();
        c.tail->tick.flush();
        c.tail->mid_exposure.flush();
    }
    h5::check(H5Fflush(streams_->file.get(), H5F_SCOPE_GLOBAL), "flushing the recording");
}

}  // namespace shaker
