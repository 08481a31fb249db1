#include "daemon/stopped_run.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <cmath>

#include "daemon/identification_record.hpp"
#include "daemon/session_places.hpp"
#include "drivers/errors.hpp"

namespace shaker {

namespace {

// What was measured before the stop, or why there is nothing.
void write_reduced(SessionWriter& file, const StoppedRun& run, const Take& take, double earliest_s) {
    MeasuredPart planned = run.planned;
    const double f = run.header.frequency_hz;
    if (earliest_s > planned.from_s)  // whole periods later
        planned.from_s += std::ceil((earliest_s - planned.from_s) * f) / f;
    const RecordedTrip& first = run.trips.front();
    const MeasuredPart part = part_before(planned, first.at_s, f);
    try {
        if (!(part.to_s > part.from_s))
            throw InputError{
                fmt::format("in state {} fewer than two periods had been measured", first.state)};
        write(file, reduce(measurement_of(take, f, part.from_s, part.to_s)), part.from_s, part.to_s);
    } catch (const InputError& e) {
        file.text("process/not_reduced", e.what());
    }
}

void write_findings(SessionWriter& file, const StoppedRun& run, const Take& take, double earliest_s) {
    write_trips(file, run.trips);
    if (run.identified != nullptr) write_identification(file, *run.identified);
    write_reduced(file, run, take, earliest_s);
}

void warn_of_lost(const StoppedRun& run) {
    for (std::size_t i = 0; i < run.tails.size(); ++i)
        if (const auto lost = run.tails[i].lost(); lost > 0)
            spdlog::warn("camera \"{}\": {} pictures found no room in its tail", run.header.views[i].camera,
                         lost);
}

}  // namespace

void finish(Recording& recording, const StoppedRun& run) {
    SessionWriter& file = recording.writer();
    for (std::size_t i = 0; i < run.tails.size(); ++i)
        for (std::size_t k = 0; k < run.tails[i].size(); ++k) recording.tail(i, run.tails[i][k]);
    warn_of_lost(run);
    write_findings(file, run, run.take, -INFINITY);
    recording.finish(run.take);
}

void record_tail(const StoppedRun& run, const std::filesystem::path& file) {
    SessionHeader header = run.header;
    header.kind = "trip";
    header.pictures = KeptPictures::full;
    header.groups = session_places(header, false);
    double at_s = run.trips.front().at_s;
    if (!std::isfinite(at_s) && !run.take.played.empty())
        at_s = static_cast<double>(run.take.played.back().tick.n) / run.take.dac_rate_hz;
    const double from_s = at_s - tail_s;
    const Take take = tail_of(run.take, from_s);
    Recording recording{file, header, {.unfinished = Unfinished::discard}};
    for (const PlayTime& p : take.played) recording.add(p);
    for (const DriveChange& c : take.changes) recording.add(c);
    for (const AccelBlock& b : take.blocks) recording.add(b);
    for (std::size_t i = 0; i < run.tails.size(); ++i) {
        const CameraTake& camera = take.cameras[i];
        const FrameTail& tail = run.tails[i];
        const bool cut = !camera.view.targets.empty() && !take.tracks[camera.first_track].tracks.empty();
        const CameraTick from = cut ? take.tracks[camera.first_track].tracks.front().tick : CameraTick{};
        bool gap = !tail.whole();
        for (std::size_t k = 0; k < tail.size(); ++k) {
            Frame frame = tail[k];
            if (cut && frame.tick < from) {
                gap = true;
                continue;
            }
            if (gap) frame.quality = frame.quality | Quality::gap;
            gap = false;
            recording.add(i, frame, {});
        }
    }
    warn_of_lost(run);
    write_findings(recording.writer(), run, take, from_s);
    recording.finish(take);
}

std::filesystem::path trip_file(const std::filesystem::path& folder,
                                std::chrono::system_clock::time_point now) {
    const std::string stem =
        fmt::format("trip-{:%Y%m%dT%H%M%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(now)));
    std::filesystem::path file = folder / (stem + ".nxs");
    for (int k = 2; std::filesystem::exists(file); ++k) file = folder / fmt::format("{}-{}.nxs", stem, k);
    return file;
}

}  // namespace shaker
