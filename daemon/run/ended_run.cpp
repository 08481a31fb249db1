#include "daemon/run/ended_run.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <iterator>

#include "daemon/recording/tables/identification_table.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/recording/tables/track_table.hpp"
#include "drivers/errors.hpp"
#include "drivers/time.hpp"

namespace shaker::run {

namespace {

// The part of the newest measurement from which the results are made.
recording::MeasuredPart measured_part(const EndedRun& run, const std::vector<recording::RecordedTrip>& trips,
                                      double earliest_s) {
    const bool any = run.finished.to_s > run.finished.from_s;
    recording::MeasuredPart planned = any ? run.finished : run.planned;
    const double f = run.header.frequency_hz;
    if (earliest_s > planned.from_s)  // whole periods later
        planned.from_s += std::ceil((earliest_s - planned.from_s) * f) / f;
    if (any) return planned;
    if (!trips.empty()) return part_before(planned, trips.front().at_s, f);
    return std::isfinite(run.data_end_s) ? part_before(planned, run.data_end_s, f) : planned;
}

std::vector<recording::RecordedTrip> recorded_trips(const EndedRun& run) {
    std::vector<recording::RecordedTrip> trips;
    if (run.stops.empty()) return trips;
    const calibration::Timebase& timebase = run.streams.timebase.recorded();
    for (const EndedRun::Stop& s : run.stops) {
        const MasterTime at =
            s.trip.on_dac_clock ? timebase.at(DacTick{s.trip.tick}) : timebase.at(AccelTick{s.trip.tick});
        trips.push_back({s.trip, name(s.state), seconds(at)});
    }
    return trips;
}

// Reduces the measured part of `streams`, which are the run's streams or their last seconds. A recording may
// have more of the run's data.
void reduce_part(const EndedRun& run, const acquisition::Streams& streams, double earliest_s,
                 Results& results, recording::Recorder* recording = nullptr) {
    const double f = run.header.frequency_hz;
    results.part = measured_part(run, results.trips, earliest_s);
    try {
        if (!(results.part.to_s > results.part.from_s))
            throw InputError{results.trips.empty()
                                 ? std::string{"no measurement was complete"}
                                 : fmt::format("in state {} fewer than two periods had been measured",
                                               results.trips.front().state)};
        const auto part = recording != nullptr ? recording->around(results.part, streams) : std::nullopt;
        results.reduction =
            reduce(measurement_of(part ? *part : streams, f, results.part.from_s, results.part.to_s));
    } catch (const InputError& e) {
        results.part = {};
        results.not_reduced = e.what();
    }
}

// Writes results, truth and trips to the recording and finishes it under its final name.
void complete(recording::Recorder& recording, const EndedRun& run, const acquisition::Streams& streams,
              const Results& results) {
    recorded::RecordingWriter& file = recording.writer();
    if (!results.trips.empty()) write_trips(file, results.trips);
    if (run.truth) {
        recording::write_true_drift(file, run.truth->v_D);
        for (std::size_t i = 0; i < run.truth->poses.size(); ++i)
            recording::write_truth(file, run.header.views[i].camera, run.truth->poses[i]);
    }
    if (run.identified) recording::write_identification(file, *run.identified);
    if (results.reduction)
        return recording.finish(streams, *results.reduction, results.part.from_s, results.part.to_s);
    recording::write_not_reduced(file, results.not_reduced);
    recording.finish(streams);
}

void warn_of_lost(const EndedRun& run) {
    for (std::size_t i = 0; i < run.tails->size(); ++i)
        if (const auto lost = (*run.tails)[i].lost(); lost > 0)
            spdlog::warn("camera \"{}\": {} pictures are missing in its last seconds: memory was full",
                         run.header.views[i].camera, lost);
}

// Adds the pictures of one camera's tail that belong to the kept end of its tracks.
void add_pictures(recording::Recorder& recording, std::size_t camera, const acquisition::RecentFrames& tail,
                  acquisition::Streams& streams, const std::function<void()>& progress) {
    const acquisition::CameraStream& c = streams.cameras[camera];
    const bool cut = !c.view.targets.empty() && !streams.tracks[c.first_track].tracks.empty();
    const CameraTick from = cut ? streams.tracks[c.first_track].tracks.front().tick : CameraTick{};
    bool gap = !tail.whole();
    for (std::size_t k = 0; k < tail.size(); ++k) {
        Frame frame = tail[k];
        if (cut && frame.tick < from) {
            gap = true;
            continue;
        }
        if (gap) frame.quality = frame.quality | Quality::gap;
        gap = false;
        add_stamps(streams, camera, frame);
        recording.add(camera, frame, {}, {});
        progress();
    }
}

// Pictures of many stops leave space for the series of the stops after them.
bool room_for_pictures(const std::filesystem::path& file) {
    std::error_code failed;
    const std::filesystem::space_info space = std::filesystem::space(file.parent_path(), failed);
    return failed || space.available >= least_free_for_tails;
}

}  // namespace

Truth truth_of(const simulated::World& world, const std::vector<View>& views,
               const recording::MeasuredPart& part, double frequency_hz) {
    Truth truth{.v_D = drift_velocity(world.truth(0), part.from_s, part.to_s, frequency_hz), .poses = {}};
    for (std::size_t i = 0; i < views.size(); ++i) truth.poses.push_back(world.truth(i));
    return truth;
}

EndedRun ended_run(const Sequence& sequence, const acquisition::Streams& streams) {
    EndedRun run;
    const control::DriveController& controller = sequence.controller();
    if (controller.identified()) run.identified = *controller.identified();
    run.notes = sequence.notes();
    if (!sequence.measured().empty()) {
        run.finished = sequence.measured().back().part;
        if (std::string doubt = sequence.mains_doubt(sequence.measured().back().asked); !doubt.empty())
            run.notes.push_back(std::move(doubt));
    }
    if (!sequence.trip()) {
        if (sequence.state() == RunState::run && run.finished.to_s <= run.finished.from_s)
            run.planned = {sequence.from_s(), sequence.to_s()};
        if (sequence.interrupted()) {
            run.interrupted = true;
            run.planned = sequence.interrupted_part();
            run.data_end_s = run.planned.to_s;
        }
        return run;
    }
    // A trip that came after the sequence's last step has no state.
    const std::size_t seen = std::min(streams.trips.size(), sequence.stops().size());
    for (std::size_t i = sequence.cause(); i < seen; ++i)
        run.stops.push_back(
            {i == sequence.cause() ? *sequence.trip() : streams.trips[i], sequence.stops().at(i).state});
    if (sequence.stops().at(sequence.cause()).measuring) run.planned = {sequence.from_s(), sequence.to_s()};
    if (!run.identified && controller.found() != nullptr) run.identified = *controller.found();
    return run;
}

Results results_of(EndedRun& run, recording::Recorder* recording) {
    Results results;
    std::vector<std::string> notes;
    settle_times(run.streams, notes);
    results.trips = recorded_trips(run);
    reduce_part(run, run.streams, -INFINITY, results, recording);
    if (!results.reduction) return results;
    std::vector<std::string>& all = results.reduction->notes;
    std::ranges::move(notes, std::back_inserter(all));
    std::ranges::move(notes_on(run.streams), std::back_inserter(all));
    std::ranges::copy(run.notes, std::back_inserter(all));
    const bool failed = std::isfinite(run.data_end_s);
    if ((failed || !results.trips.empty()) && !(run.finished.to_s > run.finished.from_s))
        all.push_back(stopped_note(run.interrupted         ? "an interruption"
                                   : results.trips.empty() ? "a failed device"
                                                           : "a limit",
                                   (results.part.to_s - results.part.from_s) * run.header.frequency_hz));
    set_doubts(*results.reduction);
    return results;
}

std::string stopped_note(std::string_view cause, double periods) {
    return fmt::format(
        "{} stopped the run: the results are from the {:.0f} periods measured clearly before the stop", cause,
        periods);
}

double end_of_data(const acquisition::Streams& streams) {
    double end_s = INFINITY;
    if (!streams.played.empty()) end_s = counted_s(streams.played.back().tick, streams.dac_rate_hz);
    if (!streams.blocks.empty()) {
        const AccelBlock& last = streams.blocks.back();
        end_s = std::min(end_s, seconds(streams.timebase.recorded().at(AccelTick{last.first.n + last.size})));
    }
    for (const acquisition::CameraStream& c : streams.cameras) end_s = std::min(end_s, c.until_s);
    return end_s;
}

void finish(recording::Recorder& recording, const EndedRun& run, const Results& results) {
    if (run.tails != nullptr) {
        for (std::size_t i = 0; i < run.tails->size(); ++i)
            for (std::size_t k = 0; k < (*run.tails)[i].size(); ++k) recording.tail(i, (*run.tails)[i][k]);
        warn_of_lost(run);
    }
    complete(recording, run, run.streams, results);
}

void record_tail(const EndedRun& run, const Results& results, const std::filesystem::path& file) {
    recorded::RecordingHeader header = run.header;
    header.kind = "trip";
    header.pictures = room_for_pictures(file) ? recorded::KeptPictures::full : recorded::KeptPictures::off;
    recording::lay_out(header, false);
    double at_s = results.trips.front().at_s;
    if (!std::isfinite(at_s) && !run.streams.played.empty())
        at_s = counted_s(run.streams.played.back().tick, run.streams.dac_rate_hz);
    const double from_s = at_s - acquisition::tail_s;
    acquisition::Streams streams = recording::tail_of(run.streams, from_s);
    recording::Recorder recording{
        file,
        header,
        {.unfinished = recording::Unfinished::discard, .progress = run.progress, .started_s = run.started_s}};
    for (const PlayTime& p : streams.played) recording.add(p);
    for (const DriveChange& c : streams.changes) recording.add(c);
    for (const AccelBlock& b : streams.blocks) recording.add(b);
    for (std::size_t i = 0; i < run.tails->size(); ++i)
        add_pictures(recording, i, (*run.tails)[i], streams, run.progress);
    warn_of_lost(run);
    Results end{.part = {}, .reduction = {}, .not_reduced = {}, .trips = results.trips};
    reduce_part(run, streams, from_s, end);
    complete(recording, run, streams, end);
}

std::filesystem::path trip_file(const std::filesystem::path& folder,
                                std::chrono::system_clock::time_point now) {
    const std::string stem =
        fmt::format("trip-{:%Y%m%dT%H%M%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(now)));
    std::filesystem::path file = folder / (stem + ".nxs");
    for (int k = 2; std::filesystem::exists(file); ++k) file = folder / fmt::format("{}-{}.nxs", stem, k);
    return file;
}

}  // namespace shaker::run
