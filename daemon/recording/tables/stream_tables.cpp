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

std::vector<Gap> gaps_of(const acquisition::Streams& streams) {
    std::vector<Gap> gaps;
    for (const PlayTime& p : streams.played)
        if (p.lost > 0) gaps.push_back({0, p.tick.n, p.lost});
    std::int64_t next = streams.blocks.empty() ? 0 : streams.blocks.front().first.n;
    for (const AccelBlock& b : streams.blocks) {
        if (b.first.n != next) gaps.push_back({1, next, b.first.n - next});
        next = b.first.n + b.size;
    }
    for (std::size_t c = 0; c < streams.cameras.size(); ++c) {
        if (streams.cameras[c].view.targets.empty()) continue;
        const std::vector<tracking::Track>& frames = streams.tracks[streams.cameras[c].first_track].tracks;
        for (std::size_t i = 1; i < frames.size(); ++i)
            if (const std::int64_t n = frames[i].tick.n - frames[i - 1].tick.n - 1; n != 0)
                gaps.push_back({2 + c, frames[i - 1].tick.n + 1, n});
    }
    return gaps;
}

std::string pictures_path(const std::string& camera) {
    return std::string{picture_columns.path} + "/" + camera;
}

void write_streams(recorded::RecordingWriter& file, const acquisition::Streams& streams) {
    write_rows(file, clock_columns, clocks_of(streams));
    write_rows(file, gap_columns, gaps_of(streams));
}

void write(recorded::RecordingWriter& file, const std::string& camera, const PictureCounts& counts) {
    write(file, numbers_of(picture_columns, counts, pictures_path(camera)));
}

}  // namespace shaker::recording
