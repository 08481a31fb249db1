#include "daemon/recording/tables/stream_tables.hpp"

namespace shaker::recording {

namespace {

constexpr const char* stream_meaning = "0: DAC, 1: accelerometer, 2 and above: cameras in their order";

constexpr std::array clock_numbers{number<&ClockRow::stream>("stream", "1", stream_meaning),
                                   number<&ClockRow::ppm>("ppm", "1e-6", "rate relative to nominal, minus 1"),
                                   number<&ClockRow::ppm_sigma>("ppm_errors", "1e-6", "standard error"),
                                   number<&ClockRow::delay_s>("delay", "s", "mean delay of the stamps"),
                                   number<&ClockRow::stamps>("stamps", "1", "number of stamps")};

constexpr std::array gap_numbers{
    number<&Gap::stream>("stream", "1", stream_meaning),
    number<&Gap::first>("first", "1", "number of the first missing sample or frame"),
    number<&Gap::count>("count", "1", "number of missing samples or frames")};

constexpr std::array picture_numbers{
    number<&PictureCounts::produced>("produced", "1", "frames of the camera: stored + dropped + not_kept"),
    number<&PictureCounts::stored>("stored", "1", "pictures in the pictures folder"),
    number<&PictureCounts::dropped>("dropped", "1", "pictures lost because the queue was full"),
    number<&PictureCounts::not_kept>("not_kept", "1", "pictures excluded by the settings")};

}  // namespace

constexpr Table<ClockRow> clock_columns{
    "clocks",
    "clocks determined from all stamps: the DAC relative to the host, all others relative to the DAC",
    clock_numbers};
constexpr Table<Gap> gap_columns{"gaps", "missing samples and frames", gap_numbers};
constexpr Table<PictureCounts> picture_columns{"pictures", "numbers of one camera's pictures",
                                               picture_numbers};

std::vector<ClockRow> clocks_of(const acquisition::Streams& streams) {
    std::vector<ClockRow> rows;
    const auto add = [&](std::size_t stream, const calibration::ClockFit& clock) {
        rows.push_back({stream, clock.ppm, clock.ppm_sigma, clock.delay.count(), clock.stamps});
    };
    const calibration::Timebase& timebase = streams.timebase.recorded();
    if (timebase.dac().stamps == 0) return rows;  // footage keeps its own clock
    add(0, timebase.dac());
    if (timebase.accelerometer().stamps > 0) add(1, timebase.accelerometer());
    for (std::size_t c = 0; c < timebase.cameras(); ++c) add(2 + c, timebase.camera(c));
    return rows;
}

void GapFinder::expect(std::size_t stream, std::int64_t first, std::int64_t next) {
    if (streams_.size() <= stream) streams_.resize(stream + 1);
    Stream& s = streams_[stream];
    if (s.next && first != *s.next) s.gaps.push_back({stream, *s.next, first - *s.next});
    s.next = next;
}

void GapFinder::add(const PlayTime& played) {
    if (played.lost > 0) streams_[0].gaps.push_back({0, played.tick.n, played.lost});
}

void GapFinder::add(const AccelBlock& block) { expect(1, block.first.n, block.first.n + block.size); }

void GapFinder::add(std::size_t camera, CameraTick frame) { expect(2 + camera, frame.n, frame.n + 1); }

std::vector<Gap> GapFinder::gaps() const {
    std::vector<Gap> all;
    for (const Stream& s : streams_) all.insert(all.end(), s.gaps.begin(), s.gaps.end());
    return all;
}

std::vector<Gap> gaps_of(const acquisition::Streams& streams) {
    GapFinder finder;
    for (const PlayTime& p : streams.played) finder.add(p);
    for (const AccelBlock& b : streams.blocks) finder.add(b);
    for (std::size_t c = 0; c < streams.cameras.size(); ++c) {
        if (streams.cameras[c].view.targets.empty()) continue;
        for (const tracking::Track& frame : streams.tracks[streams.cameras[c].first_track].tracks)
            finder.add(c, frame.tick);
    }
    return finder.gaps();
}

std::string pictures_path(const std::string& camera) {
    return std::string{picture_columns.path} + "/" + camera;
}

void write_streams(recorded::RecordingWriter& file, const acquisition::Streams& streams,
                   const std::vector<Gap>& gaps) {
    write_rows(file, clock_columns, clocks_of(streams));
    write_rows(file, gap_columns, gaps);
}

void write(recorded::RecordingWriter& file, const std::string& camera, const PictureCounts& counts) {
    write(file, numbers_of(picture_columns, counts, pictures_path(camera)));
}

}  // namespace shaker::recording
