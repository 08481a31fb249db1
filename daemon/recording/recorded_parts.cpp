#include "daemon/recording/recorded_parts.hpp"

#include <algorithm>

#include "daemon/recording/tables/track_table.hpp"

namespace shaker::recording {

namespace {

constexpr std::size_t slice_blocks = 64, slice_tracks = 1024;

// Slices from `from` to `to`, not included.
struct SliceRange {
    std::size_t from = 0, to = 0;
};

// The reduction reads from behind the last element before part.from_s to the last one that is not after
// part.to_s. Times need not increase, so the least time of each slice decides. An unknown time is not after
// to_s.
template <class Least, class Unknown>
SliceRange slices_of(std::size_t slices, const acquisition::ReadPart& part, Least least_s, Unknown unknown) {
    SliceRange range{0, slices};
    while (range.to > 0 && least_s(range.to - 1) > part.to_s && !unknown(range.to - 1)) --range.to;
    range.from = range.to;
    while (range.from > 0 && !(least_s(range.from - 1) < part.from_s)) --range.from;
    if (range.from > 0) --range.from;  // the slice with the last element before the part
    return range;
}

}  // namespace

RecordedParts::RecordedParts(const std::vector<View>& views) : views_{views} {
    for (std::size_t camera = 0; camera < views_.size(); ++camera) {
        first_track_.push_back(tracks_.size());
        for (const Target& target : views_[camera].targets) tracks_.push_back({camera, target});
    }
}

void RecordedParts::add(const AccelBlock& block) {
    if (block_rows_++ % slice_blocks == 0) blocks_.push_back({block.first.n, samples_});
    blocks_.back().least_tick = std::min(blocks_.back().least_tick, block.first.n);
    samples_ += static_cast<std::size_t>(block.size);
}

void RecordedParts::add(std::size_t camera, std::span<const double> times) {
    for (std::size_t i = 0; i < times.size(); ++i) {
        Tracks& t = tracks_[first_track_[camera] + i];
        if (t.rows++ % slice_tracks == 0) t.slices.emplace_back();
        TrackSlice& slice = t.slices.back();
        slice.unknown = slice.unknown || std::isnan(times[i]);
        slice.least_s = std::fmin(slice.least_s, times[i]);
    }
}

std::vector<AccelBlock> RecordedParts::blocks(const acquisition::ReadPart& part,
                                              const calibration::Timebase& timebase,
                                              recorded::RecordingWriter& file) const {
    if (!timebase.ready()) return {};
    const SliceRange range = slices_of(
        blocks_.size(), part,
        [&](std::size_t i) { return seconds(timebase.at(AccelTick{blocks_[i].least_tick})); },
        [](std::size_t) { return false; });
    if (range.from == range.to) return {};
    const std::size_t first = range.from * slice_blocks;
    return file.blocks(first, std::min(range.to * slice_blocks, block_rows_) - first,
                       blocks_[range.from].first_sample);
}

std::vector<tracking::Track> RecordedParts::tracks(const Tracks& of, const acquisition::ReadPart& part,
                                                   recorded::RecordingWriter& file) const {
    const SliceRange range = slices_of(
        of.slices.size(), part, [&](std::size_t i) { return of.slices[i].least_s; },
        [&](std::size_t i) { return of.slices[i].unknown; });
    const std::size_t first = range.from * slice_tracks;
    const std::size_t count = std::min(range.to * slice_tracks, of.rows) - std::min(first, of.rows);
    return read_rows(file, track_columns, track_path(views_[of.camera].camera, of.target), first, count);
}

acquisition::Streams RecordedParts::read(const MeasuredPart& part, double frequency_hz,
                                         const acquisition::Streams& streams,
                                         recorded::RecordingWriter& file) const {
    acquisition::Streams out;
    out.accelerometer = streams.accelerometer;
    out.dac_rate_hz = streams.dac_rate_hz;
    out.timebase = streams.timebase.recorded();
    if (last_) out.played.push_back(*last_);
    const acquisition::ReadPart span = part_read(streams, frequency_hz, part.from_s, part.to_s);
    out.blocks = blocks(span, out.timebase, file);
    for (const Tracks& t : tracks_)
        out.tracks.emplace_back(acquisition::track_of(views_[t.camera], t.target)).tracks =
            tracks(t, span, file);
    return out;
}

}  // namespace shaker::recording
