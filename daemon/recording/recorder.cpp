#include "daemon/recording/recorder.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/recording/folder.hpp"
#include "daemon/recording/tables/reduction_tables.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/recording/tables/track_table.hpp"
#include "daemon/recording/time_text.hpp"
#include "drivers/errors.hpp"
#include "drivers/frame_pool.hpp"
#include "drivers/recorded/h5/disk_file.hpp"
#include "drivers/recorded/h5/file_lock.hpp"
#include "drivers/recorded/pictures/picture_store.hpp"
#include "drivers/time.hpp"

namespace shaker::recording {

namespace {

constexpr double flush_s = 0.5;                             // master time between flushes
constexpr std::size_t most_waiting = 65536;                 // pieces of data: 20 s of the fastest streams
constexpr std::size_t pool_bytes = std::size_t{16} << 20U;  // size of an allocation for pictures
const std::size_t time_column = static_cast<std::size_t>(
    std::ranges::find(track_columns.numbers, std::string{"t"}, &NumberColumn<tracking::Track>::name) -
    track_columns.numbers.begin());
constexpr double live_queue_s = 2;  // duration of waiting pictures

std::filesystem::path beside(const std::filesystem::path& file, const char* ending) {
    std::filesystem::path path = file;
    path += ending;
    return path;
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
    return file.has_parent_path() ? file.parent_path() : std::filesystem::path{"."};
}

// Space that pictures take as soon as the first one arrives. Those of one second fit the space that must stay
// free.
std::uint64_t first_pictures_bytes(const recorded::RecordingHeader& header) {
    if (!recorded::keeps_all(header.pictures)) return 0;
    const auto cameras = std::ranges::count(header.views, false, &View::positions);
    return 2 * static_cast<std::uint64_t>(cameras) * pictures::usual_segment_bytes;
}

// One segment holds the pictures of the first second. 0: the usual number.
std::uint64_t segment_frames(const recorded::RecordingHeader& header, const View& view) {
    if (header.pictures != recorded::KeptPictures::first_second) return 0;
    constexpr std::uint64_t block = pictures::PictureSegment::block;
    return (static_cast<std::uint64_t>(recorded::first_second_frames(view)) + block - 1) / block * block;
}

}  // namespace

void require_new(const std::filesystem::path& file) {
    if (std::filesystem::exists(file))
        throw InputError{fmt::format(
            "{}: exists already; recordings are never overwritten, choose another name", file.string())};
    const std::filesystem::path part = beside(file, ".part");
    if (const auto writer = h5::locked_by(part))
        throw InputError{
            fmt::format("{}: is being recorded by process {}; choose another name", part.string(), *writer)};
    if (std::filesystem::exists(part))
        throw InputError{
            fmt::format("{}: belongs to a recording that was never finished; finish it by \"shakerd recover "
                        "{}\" or remove it",
                        part.string(), file.string())};
}

// Copies of pictures that wait for the disk. Memory is allocated when needed and then reused.
class Recorder::Pictures {
public:
    explicit Pictures(std::size_t most) : most_{most} {}
    FramePtr copy(const Frame& frame, const std::optional<MasterTime>& mid_exposure) {
        std::shared_ptr<Frame> to = acquire(frame);
        if (!to) return nullptr;
        to->tick = frame.tick;
        to->arrived = frame.arrived;
        to->stamp = frame.stamp;
        to->mid_exposure = mid_exposure;
        to->quality = frame.quality;
        std::ranges::copy(frame.pixels, to->pixels.begin());
        return to;
    }

private:
    std::shared_ptr<Frame> acquire(const Frame& like) {
        for (FramePool& pool : pools_)
            if (auto frame = pool.acquire()) return frame;
        if (taken_ >= most_) return nullptr;
        const std::size_t fit =
            std::max<std::size_t>(1, pool_bytes / std::max<std::size_t>(1, like.pixels.size()));
        const std::size_t frames = std::min(most_ - taken_, fit);
        pools_.emplace_back(static_cast<int>(frames), like.width, like.height, like.bytes_per_pixel);
        taken_ += frames;
        return pools_.back().acquire();
    }
    std::size_t most_, taken_ = 0;
    std::vector<FramePool> pools_;
};

Recorder::Recorder(const std::filesystem::path& file, const recorded::RecordingHeader& header,
                   const RecorderSettings& settings)
    : file_{file}, settings_{settings}, header_{header} {
    if (file.empty()) return;
    part_ = beside(file, ".part");
    require_new(file);
    require_space(file, settings.least_free_bytes, first_pictures_bytes(header));
    writer_ = std::make_unique<recorded::RecordingWriter>(part_, header);
    journal_ = std::make_unique<Journal>(beside(file, ".journal"));
    if (settings.live)
        h5::sync_folder(folder_of(file));  // data that are synchronised later need a directory entry
    ring_.emplace(most_waiting);
    for (const View& view : header.views) {
        stores_.push_back(std::make_unique<pictures::PictureStore>(
            recorded::pictures_folder(file), view.camera, segment_frames(header, view)));
        tails_.push_back(
            std::make_unique<pictures::PictureStore>(recorded::pictures_folder(file), view.camera + "-tail"));
        const double frames = settings.live ? std::ceil(live_queue_s * view.frame_rate_hz) : 1;
        waiting_.push_back(std::make_unique<Pictures>(static_cast<std::size_t>(std::max(1.0, frames))));
        std::vector<std::size_t>& tables = tables_.emplace_back();
        for (const Target& t : view.targets) tables.push_back(writer_->table(track_path(view.camera, t)));
    }
    counts_.resize(header.views.size());
    first_.resize(header.views.size());
    if (settings.final_times) parts_.emplace(header.views);
}

Recorder::~Recorder() {
    if (!writer_) return;
    if (settings_.unfinished == Unfinished::keep) {
        while (step()) {
        }
        if (!failed_ && !closed_) flush();
        return;
    }
    stores_.clear();
    tails_.clear();
    writer_.reset();
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
    std::filesystem::remove(beside(file_, ".journal"), ignored);
    std::filesystem::remove_all(recorded::pictures_folder(file_), ignored);
}

// The queue has pointers: pieces are of very different size, and memory is needed for waiting ones only.
void Recorder::push(Piece piece) {
    if (!on()) return;
    if (ring_->push(std::make_shared<const Piece>(std::move(piece))))
        ++pushed_;
    else
        ++lost_;
    if (!settings_.live) step();
}

bool Recorder::wants(std::size_t camera, const Frame& frame) {
    if (!frame.sightings.empty() || header_.pictures == recorded::KeptPictures::off) return false;
    if (recorded::keeps_all(header_.pictures)) return true;
    std::optional<CameraTick>& first = first_[camera];
    if (!first) first = frame.tick;
    return frame.tick.n - first->n < recorded::first_second_frames(header_.views[camera]);
}

void Recorder::add(std::size_t camera, const Frame& frame, std::span<const tracking::Track> tracks,
                   const std::optional<MasterTime>& mid_exposure) {
    if (!on()) return;
    Entry entry{camera, {}, nullptr, wants(camera, frame), {}};
    entry.frame.tick = frame.tick;
    entry.frame.arrived = frame.arrived;
    entry.frame.stamp = frame.stamp;
    entry.frame.mid_exposure = frame.mid_exposure ? frame.mid_exposure : mid_exposure;
    entry.frame.quality = frame.quality;
    entry.frame.sightings = frame.sightings;
    for (const tracking::Track& t : tracks) {
        const std::vector<double> row = row_of(track_columns, t);
        entry.rows.insert(entry.rows.end(), row.begin(), row.end());
    }
    if (entry.wanted && !frame.pixels.empty() && !failed_)
        entry.picture = waiting_[camera]->copy(frame, entry.frame.mid_exposure);
    push(std::move(entry));
}

void Recorder::add(const FinishedMeasurement& finished) {
    if (!on()) return;
    FinishedMeasurement& f = finished_.emplace_back(finished);
    f.time = settings_.live ? local_time_text() : time_text_after(header_.started, f.part.to_s);
    push(f);
}

bool Recorder::step() {
    if (!on()) return false;
    bool any = false;
    while (const auto next = ring_->pop()) {
        const Piece* piece = next->get();
        any = true;
        ++popped_;
        if (failed_) {
            ++lost_;
            if (const auto* entry = std::get_if<LogEntry>(piece)) write_journal(*entry);
            continue;
        }
        try {
            write(*piece);
        } catch (const std::exception& e) {
            fail(e.what());
        }
    }
    return any;
}

void Recorder::write(const Piece& piece) {
    if (const auto* played = std::get_if<PlayTime>(&piece)) {
        writer_->add(*played);
        gaps_.add(*played);
        if (parts_) parts_->add(*played);
        advance(counted_s(played->tick, header_.dac.rate_hz));
    } else if (const auto* change = std::get_if<DriveChange>(&piece)) {
        writer_->add(*change);
    } else if (const auto* block = std::get_if<AccelBlock>(&piece)) {
        writer_->add(*block);
        gaps_.add(*block);
        if (parts_) parts_->add(*block);
        if (header_.dac.rate_hz <= 0) advance(counted_s(block->first, header_.accelerometer.rate_hz));
    } else if (const auto* part = std::get_if<MeasuredPart>(&piece)) {
        recording::write(*writer_, *part);
    } else if (const auto* finished = std::get_if<FinishedMeasurement>(&piece)) {
        recording::write(*writer_, *finished);
    } else if (const auto* entry = std::get_if<LogEntry>(&piece)) {
        state_ = entry->state;
        journal_->add(*entry);
        recording::write(*writer_, *entry);
    } else {
        write(std::get<Entry>(piece));
    }
}

void Recorder::write(const Entry& entry) {
    PictureCounts& count = counts_[entry.camera];
    ++count.produced;
    std::uint64_t picture = 0;
    if (entry.picture) {
        // A simulated run can be made again: a crash may lose a large block of its pictures.
        picture = stores_[entry.camera]->add(*entry.picture, !settings_.live || !ring_->empty());
        ++count.stored;
    } else {
        ++(entry.wanted ? count.dropped : count.not_kept);
    }
    writer_->add(entry.camera, entry.frame, picture);
    const std::vector<std::size_t>& tables = tables_[entry.camera];
    if (tables.empty()) return;
    gaps_.add(entry.camera, entry.frame.tick);
    if (entry.rows.empty()) return;
    tracks_written_ = true;
    const std::size_t columns = entry.rows.size() / tables.size();
    for (std::size_t i = 0; i < tables.size(); ++i)
        writer_->row(tables[i], std::span{entry.rows}.subspan(i * columns, columns));
    if (!parts_) return;
    std::vector<double> times;
    for (std::size_t i = 0; i < tables.size(); ++i) times.push_back(entry.rows[i * columns + time_column]);
    parts_->add(entry.camera, times);
}

void Recorder::advance(double s) {
    now_s_ = std::max(now_s_, s);
    if (now_s_ < flushed_s_ + flush_s) return;
    flushed_s_ = now_s_;
    flush();
    if (const std::uint64_t room = free_bytes(file_); room < settings_.least_free_bytes)
        throw DeviceError{fmt::format("{}: the disk has {} free; {} must stay free", part_.string(),
                                      gigabytes(room), gigabytes(settings_.least_free_bytes))};
}

// Pictures first, so that no row refers to a missing picture.
void Recorder::flush() try {
    if (settings_.live)
        for (const auto& store : stores_) store->sync();
    writer_->flush();
    if (settings_.live) writer_->sync();
} catch (const std::exception& e) {
    fail(e.what());
}

void Recorder::fail(const std::string& why) noexcept {
    {
        const std::scoped_lock lock{mutex_};
        if (failure_) return;
        failure_ = why;
        failed_ = true;
    }
    write_journal({now_s_, state_, "the recording stopped here: " + why});
}

// The journal gets the reason of a failure even when nothing else can be written. The journal itself may have
// failed, so errors are ignored.
void Recorder::write_journal(const LogEntry& entry) noexcept try {
    journal_->add(entry);
} catch (const std::exception&) {
    return;
}

std::optional<std::string> Recorder::failure() const {
    if (!failed_) return std::nullopt;
    const std::scoped_lock lock{mutex_};
    return failure_;
}

double Recorder::backlog() const noexcept {
    return static_cast<double>(pushed_ - popped_) / static_cast<double>(most_waiting);
}

recorded::RecordingWriter& Recorder::writer() {
    while (step()) {
    }
    if (const auto why = failure())
        throw DeviceError{*why + "; the data recorded until then are in " + part_.string()};
    return *writer_;
}

void Recorder::tail(std::size_t camera, const Frame& frame) {
    if (!frame.pixels.empty()) tails_.at(camera)->add(frame);
    settings_.progress();
}

void Recorder::finish(const acquisition::Streams& streams, const reduction::Reduction& reduction,
                      double from_s, double to_s) {
    if (!on()) return;
    const MeasuredPart part{from_s, to_s};
    recording::write(writer(), reduction, part);
    complete(streams, {.part = part, .reduction = &reduction});
}

void Recorder::finish(const acquisition::Streams& streams) {
    if (on()) complete(streams, {});
}

void Recorder::complete(const acquisition::Streams& streams, const Known& known) {
    recorded::RecordingWriter& file = writer();
    if (!tracks_written_)
        recording::write(file, tables_of(streams));
    else if (!settings_.final_times)
        write_times(file, streams);
    for (const FinishedMeasurement& f : finished_) {
        recording::write(file, result_of(f, streams, known));
        settings_.progress();
    }
    write_streams(file, streams, gaps_.gaps());
    // Not 0 only when the disk was blocked and the stop came too late.
    write_pieces_lost(file, lost_);
    for (std::size_t c = 0; c < counts_.size(); ++c)
        recording::write(file, header_.views[c].camera, counts_[c]);
    if (!header_.started.empty())
        file.text("end_time", time_text_after(header_.started, now_s_ - settings_.started_s));
    for (const auto* stores : {&stores_, &tails_}) pictures::finish(*stores, settings_.progress);
    file.close();
    closed_ = true;
    give_name();
    writer_.reset();
    journal_.reset();
    std::filesystem::remove(beside(file_, ".journal"));
}

MeasuredResult Recorder::result_of(const FinishedMeasurement& finished, const acquisition::Streams& streams,
                                   const Known& known) {
    if (known.reduction != nullptr && finished.part == known.part) return {finished, *known.reduction, {}};
    const auto part = around(finished.part, streams);
    return reduced(finished, part ? *part : streams, header_.frequency_hz);
}

std::optional<acquisition::Streams> Recorder::around(const MeasuredPart& part,
                                                     const acquisition::Streams& streams) {
    if (!parts_) return std::nullopt;
    return parts_->read(part, header_.frequency_hz, streams, writer());
}

// The file stays locked until it has its name.
void Recorder::give_name() try {
    h5::rename_new(part_, file_);
    h5::sync_folder(folder_of(file_));
} catch (const InputError& e) {
    throw DeviceError{fmt::format(
        "{}; the recording is complete: move the other file away, then run \"shakerd recover {}\"", e.what(),
        file_.string())};
}

}  // namespace shaker::recording
