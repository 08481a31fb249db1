#include "daemon/commands/recover.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/recording/journal.hpp"
#include "daemon/recording/replay.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/tables/reduction_tables.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/recording/tables/stream_tables.hpp"
#include "daemon/recording/tables/track_table.hpp"
#include "daemon/recording/tables/trip_table.hpp"
#include "daemon/recording/time_text.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/sandbox/confined.hpp"
#include "daemon/sandbox/new_files.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/file_lock.hpp"
#include "drivers/recorded/pictures/picture_check.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "drivers/time.hpp"

namespace shaker::commands {

namespace {

constexpr std::array recover_arguments{
    manual::Argument{.name = "FILE", .help = "Recording, or its .part", .kind = manual::Kind::file},
    manual::json_argument};

// Data found in the .part file, cut to its last valid seal, and in the files beside it.
struct Recovered {
    std::vector<std::vector<std::uint64_t>> pictures;  // by camera and frame: number of the picture; 0: lost
    std::vector<recording::PictureCounts> counts;
    std::vector<recording::LogEntry> log;  // entries of the journal that the file does not have
    acquisition::Streams streams;
    std::optional<reduction::Reduction> reduction;
    recording::MeasuredPart part;
    std::vector<recording::MeasuredResult> measured;  // results of every finished measurement
    std::string why;                                  // reason why there is no reduction
    std::vector<std::string> notes;
    std::uint64_t frames = 0, kept = 0, pictures_lost = 0;
    double until_s = 0;
};

using Check = pictures::PictureCheck (*)(const std::filesystem::path&, const std::string&);

// If nothing is readable, no picture is intact, and a note reports why.
pictures::PictureCheck checked(Check check, const std::filesystem::path& folder, const std::string& camera,
                               std::vector<std::string>& notes) try {
    return check(folder, camera);
} catch (const InputError& e) {
    notes.emplace_back(e.what());
    return {};
}

std::string words_for(const std::string& camera, const pictures::BadPicture& p) {
    return fmt::format("camera \"{}\": picture {} {}", camera, p.number, words_for(p.fault));
}

bool any_picture(const std::vector<std::uint64_t>& numbers) {
    return std::ranges::any_of(numbers, [](std::uint64_t n) { return n > 0; });
}

void find_pictures(const recorded::RecordingReader& file, const std::filesystem::path& folder, Check check,
                   Recovered& found) {
    for (const View& view : file.header().views) {
        const auto wanted = [&, frames = file.frames(view.camera)](std::size_t i) {
            const recorded::KeptPictures kept = file.header().pictures;
            if (view.positions || kept == recorded::KeptPictures::off) return false;
            return recorded::keeps_all(kept) ||
                   frames[i].tick.n - frames[0].tick.n < recorded::first_second_frames(view);
        };
        std::vector<std::uint64_t> pictures = file.pictures_of(view.camera);
        recording::PictureCounts counts{.produced = pictures.size()};
        const pictures::PictureCheck stored = any_picture(pictures)
                                                  ? checked(check, folder, view.camera, found.notes)
                                                  : pictures::PictureCheck{};
        for (const pictures::BadPicture& p : stored.bad)
            if (p.number <= stored.last) found.notes.push_back(words_for(view.camera, p));
        std::ranges::copy(stored.damaged, std::back_inserter(found.notes));
        for (std::size_t i = 0; i < pictures.size(); ++i) {
            std::uint64_t& n = pictures[i];
            if (n > 0 && !std::ranges::binary_search(stored.whole, n)) {
                ++found.pictures_lost;
                n = 0;
            }
            ++(n > 0 ? counts.stored : wanted(i) ? counts.dropped : counts.not_kept);
        }
        found.frames += counts.produced;
        found.kept += counts.stored;
        found.pictures.push_back(std::move(pictures));
        found.counts.push_back(counts);
    }
}

// Reads the journal's entries after the file's last seal; they show why the run ended.
void find_log(const recorded::RecordingReader& file, const std::filesystem::path& journal, Recovered& found) {
    const std::size_t known = recording::read_log(file).size();
    const std::vector<recording::LogEntry> all = recording::read_journal(journal);
    for (std::size_t i = known; i < all.size(); ++i) found.log.push_back(all[i]);
    if (all.empty()) return;
    const recording::LogEntry& last = all.back();
    found.notes.push_back(fmt::format("last entry of the journal: {:.3f} s, state {}{}{}", last.t_s,
                                      last.state, last.text.empty() ? "" : ", ", last.text));
}

void find_results(const recorded::RecordingReader& file, Recovered& found) {
    found.streams = recording::stored_streams(file, found.notes);
    if (!found.streams.played.empty())
        found.until_s = counted_s(found.streams.played.back().tick, found.streams.dac_rate_hz);
    const double f = file.header().frequency_hz;
    for (const recording::FinishedMeasurement& m : recording::read_finished(file))
        found.measured.push_back(recording::reduced(m, found.streams, f));
    if (!found.measured.empty() && found.measured.back().reduction) {
        found.part = found.measured.back().measurement.part;
        found.reduction = found.measured.back().reduction;
        return;
    }
    const auto begun = recording::read_measurement(file);
    if (begun) found.part = recording::part_before(*begun, found.until_s, f);
    try {
        if (!(found.part.to_s > found.part.from_s))
            throw InputError{"the recording ended before two periods had been measured"};
        found.reduction = reduce(measurement_of(found.streams, f, found.part.from_s, found.part.to_s));
    } catch (const InputError& e) {
        found.why = e.what();
    }
}

void complete(recorded::RecordingWriter& file, const recorded::RecordingHeader& header,
              const Recovered& found) {
    for (std::size_t c = 0; c < found.pictures.size(); ++c) {
        file.replace_pictures(header.views[c].camera, found.pictures[c]);
        recording::write(file, header.views[c].camera, found.counts[c]);
    }
    for (const recording::LogEntry& entry : found.log) recording::write(file, entry);
    recording::write_times(file, found.streams);
    // Results that were written before the end are computed again.
    for (const recorded::GroupLayout& g : recording::reduction_places()) file.clear(g.path);
    for (const char* group :
         {recording::clock_columns.path, recording::gap_columns.path, recording::note_columns.path})
        file.clear(group);
    if (header.schema > 1) recording::clear_measured(file);
    for (const recording::MeasuredResult& result : found.measured) recording::write(file, result);
    recording::write_streams(file, found.streams, recording::gaps_of(found.streams));
    if (found.reduction) {
        recording::write(file, *found.reduction, found.part);
    } else {
        recording::write_reduced_part(file, {NAN, NAN});
        recording::write_not_reduced(file, found.why);
    }
    if (!header.started.empty())
        file.text("end_time", recording::time_text_after(header.started, found.until_s));
    recording::write_recovered(
        file, fmt::format("the writer ended at {:.3f} s without closing the file", found.until_s));
    file.close();
}

void print_recovered(const std::filesystem::path& file, const Recovered& found, bool json) {
    if (json) {
        const nlohmann::json j{{"file", file.string()},
                               {"until_s", found.until_s},
                               {"frames", found.frames},
                               {"pictures", found.kept},
                               {"pictures_lost", found.pictures_lost},
                               {"reduced", found.reduction.has_value()},
                               {"measurements", found.measured.size()},
                               {"notes", found.notes}};
        fmt::print("{}\n", report::json_text(j));
        return;
    }
    fmt::print("recovered: {}, complete up to {:.3f} s: {} frames, {} pictures, {} pictures lost\n",
               file.string(), found.until_s, found.frames, found.kept, found.pictures_lost);
    for (const std::string& note : found.notes) fmt::print("  note: {}\n", note);
    if (!found.why.empty()) fmt::print("  no results: {}\n", found.why);
}

// Only pictures with a row in the table count. The others were lost when the writer ended, and an earlier
// recovery removed their rows.
void verify_pictures(const std::filesystem::path& folder, const std::string& camera,
                     const std::vector<std::uint64_t>& numbers, Recovered& found) {
    std::set<std::uint64_t> lost{numbers.begin(), numbers.end()};
    lost.erase(0);
    found.kept += lost.size();
    const pictures::PictureCheck check = checked(pictures::verify_frames, folder, camera, found.notes);
    for (const std::uint64_t n : check.whole) lost.erase(n);
    found.kept -= lost.size();
    found.pictures_lost += lost.size();
    for (const pictures::BadPicture& p : check.bad)
        if (lost.erase(p.number) > 0) found.notes.push_back(words_for(camera, p));
    if (!lost.empty())
        found.notes.push_back(
            fmt::format("camera \"{}\": {} pictures, the first is number {}, are in no file", camera,
                        lost.size(), *lost.begin()));
    std::ranges::copy(check.damaged, std::back_inserter(found.notes));
}

// Verifies a finished recording without changing it.
bool verify(const std::filesystem::path& path, bool json) {
    const recorded::RecordingReader file{path};
    Recovered found;
    found.notes = file.damage();
    for (const View& view : file.header().views) {
        const std::vector<std::uint64_t> pictures = file.pictures_of(view.camera);
        found.frames += pictures.size();
        if (any_picture(pictures))
            verify_pictures(recorded::pictures_folder(path), view.camera, pictures, found);
    }
    const bool whole = found.notes.empty();
    if (json) {
        print_recovered(path, found, true);
        return whole;
    }
    fmt::print("{}: finished recording, {}: {} frames, {} pictures\n", path.string(),
               whole ? "intact" : "CHANGED since it was written", found.frames, found.kept);
    for (const std::string& note : found.notes) fmt::print("  {}\n", note);
    return whole;
}

// Keeps a recorder and another recovery away from the file.
h5::FileLock lock_of(const std::filesystem::path& part) {
    if (auto lock = h5::FileLock::take(part)) return std::move(*lock);
    const pid_t by = h5::locked_by(part).value_or(0);
    throw InputError{fmt::format(
        "{}: is being recorded by process {}, or recovered by it; nothing was changed. Wait until "
        "the recording is complete",
        part.string(), by)};
}

// The same for the pictures, which may be those of a recording with another name. No folder: no lock.
std::optional<h5::FileLock> lock_of_pictures(const std::filesystem::path& folder) {
    if (!std::filesystem::exists(std::filesystem::symlink_status(folder))) return std::nullopt;
    if (auto lock = h5::FileLock::take_folder(folder, h5::Sharing::alone)) return lock;
    throw InputError{
        fmt::format("{}: another process records or recovers these pictures; nothing was changed. Wait until "
                    "it has ended",
                    folder.string())};
}

int in_child(const RecoverOptions& options, const sandbox::Confinement& allowed) {
    return confined(options.file.string(), allowed,
                    [&] { return recover(options) ? manual::exit_ok : manual::exit_not_identical; });
}

}  // namespace

RecoveredFiles recovered_files(const RecoverOptions& options) {
    std::filesystem::path file = options.file;
    if (file.extension() == ".part") file.replace_extension();
    const auto with = [&](const char* ending) { return std::filesystem::path{file} += ending; };
    return {.file = file, .part = with(".part"), .journal = with(".journal")};
}

bool recover(const RecoverOptions& options) {
    const auto [file, part, journal] = recovered_files(options);
    const std::filesystem::path& working = options.working;
    if (std::filesystem::exists(file)) return verify(file, options.json);
    if (file.filename() == campaign::table_name)
        throw InputError{fmt::format(
            "{}: the table of a campaign's points is not recovered but made again from its recordings: give "
            "\"shakerd campaign {} --continue\"",
            options.file.string(), std::filesystem::absolute(file).parent_path().string())};
    if (!std::filesystem::exists(part))
        throw InputError{fmt::format("neither {} nor {} exists", file.string(), part.string())};
    const h5::FileLock lock = lock_of(part);
    // The recording may have been completed before it was locked.
    if (!lock.is_still(part)) return verify(file, options.json);
    const std::filesystem::path folder = recorded::pictures_folder(file);
    const std::optional<h5::FileLock> locked = lock_of_pictures(folder);
    std::filesystem::copy_file(part, working);
    try {
        recorded::RecordingWriter::mend(working).close();
    } catch (const InputError& e) {
        throw InputError{fmt::format("{}: nothing can be recovered, no data were complete yet: {}",
                                     part.string(), e.what())};
    }
    Recovered found;
    recorded::RecordingHeader header;
    {
        const recorded::RecordingReader copy{working};
        recording::require_known_schema(copy);
        header = copy.header();
        find_pictures(copy, folder, locked ? pictures::finish_frames : pictures::verify_frames, found);
        find_log(copy, journal, found);
        find_results(copy, found);
    }
    recorded::RecordingWriter mended = recorded::RecordingWriter::mend(working);
    complete(mended, header, found);
    print_recovered(file, found, options.json);
    return true;
}

int recover_confined(RecoverOptions options) {
    const RecoveredFiles files = recovered_files(options);
    const std::filesystem::path folder = files.file.parent_path();
    sandbox::Confinement allowed = sandbox::confinement_for(options.file);
    const std::filesystem::path pictures = recorded::pictures_folder(files.file);
    allowed.files = {.lists = {folder.empty() ? "." : folder},
                     .reads = {files.file, files.part, files.journal, pictures}};
    const bool finished = std::filesystem::exists(files.file);
    if (finished || !std::filesystem::exists(files.part)) return in_child(options, allowed);
    sandbox::NewRecording fresh{files.file};
    options.working = fresh.working();
    allowed.files.writes = {fresh.folder(), pictures};
    const int status = in_child(options, allowed);
    // The recorder may have finished the file meanwhile: it was only verified.
    if (status == manual::exit_ok && std::filesystem::exists(options.working)) fresh.keep();
    return status;
}

namespace {

int act_on_recover(const manual::Values& values) {
    return recover_confined({.file = values.text("FILE"), .json = values.has("--json")});
}

}  // namespace

manual::Command recover_row() {
    return {.name = "recover",
            .summary = "Finish a recording after a crash, or verify a finished one",
            .details = "The .part file is not changed. Exit status 4 means that a finished file was changed.",
            .arguments = recover_arguments,
            .example = "shakerd recover run.nxs.part",
            .exit_statuses = {manual::exit_device, manual::exit_not_identical},
            .act = act_on_recover};
}

}  // namespace shaker::commands
