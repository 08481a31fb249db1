#include "daemon/run/recordings.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "daemon/acquisition/run_loops.hpp"
#include "daemon/acquisition/streams.hpp"
#include "daemon/report/results.hpp"
#include "daemon/run/run_setup.hpp"
#include "drivers/errors.hpp"

namespace shaker::run {

namespace {

constexpr std::chrono::milliseconds space_every{500};

// Counts since the start of the run; the devices count from the start of the program.
std::vector<DeviceReport> lost_since(const std::vector<DeviceReport>& before, std::vector<DeviceReport> now) {
    for (std::size_t i = 0; i < now.size() && i < before.size(); ++i) {
        DeviceCounts& c = now[i].counts;
        const DeviceCounts& b = before[i].counts;
        c = {c.taken - b.taken, c.lost - b.lost, c.incidents - b.incidents, c.reopened - b.reopened};
    }
    return now;
}

// An operator's stop of a silent bench: it leaves a line in the log and no file, so that repeated stops
// cannot fill the disk.
bool stopped_at_rest(const Sequence& sequence, const acquisition::Streams& streams) {
    if (!sequence.trip() || driving(sequence.stops().at(sequence.cause()).state)) return false;
    const auto since = streams.trips.begin() + static_cast<std::ptrdiff_t>(sequence.cause());
    return std::all_of(since, streams.trips.end(),
                       [](const safety::Trip& trip) { return trip.cause == safety::Cause::operator_stop; });
}

recording::RecordedRate rate_of(const std::filesystem::path& file, double lasted_s,
                                recorded::KeptPictures kept) {
    std::error_code failed;
    const auto bytes = static_cast<double>(std::filesystem::file_size(file, failed));
    double pictures = 0;
    for (const auto& part : std::filesystem::directory_iterator{recorded::pictures_folder(file), failed})
        pictures += static_cast<double>(part.file_size(failed));
    return {bytes / lasted_s, pictures / lasted_s, kept, lasted_s};
}

}  // namespace

std::string stem_now() {
    const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    return fmt::format("run-{:%Y%m%dT%H%M%SZ}", fmt::gmtime(now));
}

Recordings::Recordings(bench::Bench& bench, acquisition::Collector& collector,
                       const RecordingsSettings& settings)
    : bench_{bench}, collector_{collector}, settings_{settings} {
    if (settings.on_call) folder_ = recording::lock_folder(settings.folder);
    ask_for_space();
}

std::filesystem::path Recordings::file_named(const std::string& name) const {
    return settings_.folder / (name.empty() ? name : name + ".nxs");
}

std::filesystem::path Recordings::free_name() const {
    const std::string now = stem_now();
    std::filesystem::path file = file_named(now);
    for (int k = 2; std::filesystem::exists(file); ++k) file = file_named(fmt::format("{}-{}", now, k));
    return file;
}

void Recordings::remark(const std::string& text, const Sequence& sequence) {
    const recording::LogEntry entry{sequence.now_s(), run::name(sequence.state()), "remark: " + text};
    if (on()) return recording_->add(entry);
    if (remarks_.size() == most_remarks) remarks_.pop_front();
    remarks_.push_back(entry);
}

void Recordings::require_free() const {
    if (finishing())
        throw InputError{
            "the previous recording is still being finished; start the next recorded run after that"};
    if (preparing()) throw InputError{"another recording is being opened; give the order again in a moment"};
}

void Recordings::begin(const RunOptions& run, const std::filesystem::path& file, double now_s) {
    if (!file.empty()) require_free();
    const bool with_truth = !settings_.on_call && bench_.world != nullptr;
    header_ = run_header(bench_, collector_.views(), run, settings_.live, with_truth);
    started_s_ = now_s;
    notes_before_ = 0;
    count_from_now();
    if (file.empty()) return;
    const bool learns = settings_.on_call && recorded::keeps_all(run.pictures);
    if (learns) header_.views = collector_.views_now();
    start(file, std::make_shared<recording::Recorder>(file, header_, settings_for(started_s_)));
    if (learns) collector_.relearn(header_.views);
}

void Recordings::count_from_now() {
    before_ = device_reports(bench_.rig);
    for (std::size_t i = 0; i < safety::causes; ++i)
        warned_[i] = collector_.channels().warnings[static_cast<safety::Cause>(i)];
}

recording::RecorderSettings Recordings::settings_for(double started_s) {
    return {.live = settings_.live,
            .final_times = settings_.on_call,
            .progress = [this] { ++progress_; },
            .started_s = started_s};
}

void Recordings::start(const std::filesystem::path& file, std::shared_ptr<recording::Recorder> recording) {
    file_ = file;
    {
        const std::scoped_lock lock{mutex_};
        recording_ = std::move(recording);
    }
    watch_ = std::make_unique<RecordingMonitor>(*recording_);
    for (const recording::LogEntry& remark : remarks_) recording_->add(remark);
    remarks_.clear();
    collector_.record(recording_.get());
    begun_s_ = INFINITY;
    ended_long_ = false;
}

void Recordings::prepare(const RunOptions& run, const std::filesystem::path& file, double now_s, For what) {
    require_free();
    auto p = std::make_shared<Prepared>(
        Prepared{.file = file,
                 .header = run_header(bench_, collector_.views(), run, settings_.live, false),
                 .started_s = now_s,
                 .what = what,
                 .learns = what == For::start && recorded::keeps_all(run.pictures)});
    if (p->learns) p->header.views = collector_.views_now();
    {
        const std::scoped_lock lock{mutex_};
        prepared_ = std::move(p);
    }
    if (!settings_.live) open_prepared();
}

bool Recordings::opening() const {
    const std::scoped_lock lock{mutex_};
    return prepared_ && !prepared_->recording && !prepared_->failure;
}

std::shared_ptr<Recordings::Prepared> Recordings::take_prepared() {
    const std::scoped_lock lock{mutex_};
    return std::exchange(prepared_, nullptr);
}

void Recordings::begin_prepared() {
    const std::shared_ptr<Prepared> p = take_prepared();
    if (p->failure) std::rethrow_exception(p->failure);
    header_ = p->header;
    started_s_ = p->started_s;
    notes_before_ = 0;
    count_from_now();
    p->recording->keep_unfinished();
    start(p->file, std::move(p->recording));
    if (p->learns) collector_.relearn(header_.views);
}

bool Recordings::preparing() const {
    const std::scoped_lock lock{mutex_};
    return prepared_ != nullptr;
}

bool Recordings::prepared() const {
    const std::scoped_lock lock{mutex_};
    return prepared_ && prepared_->recording && !prepared_->unwanted;
}

void Recordings::join(const Sequence& sequence) {
    const std::shared_ptr<Prepared> p = take_prepared();
    header_ = p->header;
    started_s_ = sequence.now_s();
    notes_before_ = sequence.notes().size();
    count_from_now();
    p->recording->keep_unfinished();
    start(p->file, std::move(p->recording));
    watch_->omit_before(sequence);
}

void Recordings::discard() {
    {
        const std::scoped_lock lock{mutex_};
        if (prepared_) prepared_->unwanted = true;
    }
    if (!settings_.live) open_prepared();
}

// Opens the file of a recording that waits for a run, or removes it. False when there is nothing to do.
bool Recordings::open_prepared() {
    std::shared_ptr<Prepared> p;  // the last reference to an unwanted one: its end removes the file
    {
        const std::scoped_lock lock{mutex_};
        const bool known = prepared_ && (prepared_->recording || prepared_->failure);
        if (!prepared_ || (known && !prepared_->unwanted)) return false;
        p = prepared_;
        if (p->unwanted) {
            prepared_ = nullptr;
            return true;
        }
    }
    FinishedRun failed;
    std::shared_ptr<recording::Recorder> recording;
    try {
        if (!p->file.has_filename()) p->file = free_name();
        recording::RecorderSettings settings = settings_for(p->started_s);
        settings.unfinished = recording::Unfinished::discard;
        recording = std::make_shared<recording::Recorder>(p->file, p->header, settings);
    } catch (const std::exception&) {
        failed.file = p->file;
        failed.failure = std::current_exception();
        failed.data = std::filesystem::exists(p->file.string() + ".part");
    }
    const std::scoped_lock lock{mutex_};
    p->recording = std::move(recording);
    if (failed.failure && p->what == For::start) {
        p->failure = failed.failure;
    } else if (failed.failure) {
        prepared_ = nullptr;
        finished_.push_back(std::move(failed));
    }
    return true;
}

std::vector<std::string> Recordings::warnings() const {
    safety::Warnings since;
    for (std::size_t i = 0; i < safety::causes; ++i) {
        const auto cause = static_cast<safety::Cause>(i);
        since.count(cause, collector_.channels().warnings[cause] - warned_[i]);
    }
    return notes_on(since);
}

std::string Recordings::name() const {
    if (on()) return file_.filename().string();
    return finishing() ? closing_ : std::string{};
}

void Recordings::update(Sequence& sequence, acquisition::Channels& channels) {
    if (!on()) return;
    begun_s_ = std::min(begun_s_, sequence.now_s());
    watch_->update(sequence, collector_.streams(), channels);
    if (sequence.now_s() < begun_s_ + settings_.most_s || ended_long_) return;
    if (const RunState s = sequence.state(); s != RunState::ramp && s != RunState::run) return;
    ended_long_ = true;
    sequence.end(channels);
}

// The run without its streams.
EndedRun Recordings::ended(const Sequence& sequence) const {
    EndedRun run = ended_run(sequence, collector_.streams());
    run.header = header_;
    const auto before = [&](const recording::MeasuredPart& part) { return part.from_s < started_s_; };
    if (before(run.finished)) run.finished = {};
    if (before(run.planned)) run.planned = {};
    run.notes.erase(run.notes.begin(), run.notes.begin() + static_cast<std::ptrdiff_t>(notes_before_));
    run.started_s = started_s_;
    std::vector<std::string> lost = report::notes_on(lost_since(before_, device_reports(bench_.rig)));
    run.notes.insert(run.notes.begin(), lost.begin(), lost.end());
    std::ranges::move(warnings(), std::back_inserter(run.notes));
    return run;
}

FinishedRun Recordings::abandon(const Sequence& sequence, std::exception_ptr why) {
    FinishedRun f;
    f.run = ended(sequence);
    f.run.data_end_s = end_of_data(collector_.streams());
    f.run.streams = hand_over(collector_.streams(), INFINITY);
    f.results = results_of(f.run);
    f.failure = std::move(why);
    f.abandoned = true;
    return f;
}

void Recordings::finish(const Sequence& sequence) {
    if (settings_.on_call && !on() && (!sequence.trip() || stopped_at_rest(sequence, collector_.streams())))
        return;
    auto job = std::make_unique<Job>();
    EndedRun& run = job->run.run;
    run = ended(sequence);
    run.progress = [this] { ++progress_; };
    if (sequence.measuring() && run.planned.to_s > run.planned.from_s) {
        run.interrupted = true;
        run.data_end_s = run.planned.to_s = std::min(run.planned.to_s, sequence.now_s());
    }
    if (!run.stops.empty()) {
        collector_.close_tails();
        run.tails = &collector_.tails();
    }
    if (!settings_.on_call && bench_.world != nullptr && on() && run.stops.empty())
        run.truth = truth_of(*bench_.world, header_.views, run.finished, header_.frequency_hz);
    closing_ = on() ? file_.filename().string() : std::string{};
    if (on()) {
        job->run.file = file_;
        job->run.whole = true;
        job->lasted_s = sequence.now_s() - begun_s_;
        watch_.reset();
        collector_.record(nullptr);
    }
    // Copying an hour of streams would block this thread too long, so the streams are moved.
    const double keep_from_s =
        std::min(sequence.now_s() - kept_streams_s, sequence.measuring() ? sequence.from_s() - 1 : INFINITY);
    run.streams = !settings_.on_call || on()
                      ? hand_over(collector_.streams(), settings_.on_call ? keep_from_s : INFINITY)
                      : collector_.streams();
    if (settings_.on_call && !on()) run.streams.dropped = {};  // of earlier runs
    ++unfinished_;
    {
        const std::scoped_lock lock{mutex_};
        job->recording = std::move(recording_);
        recording_ = nullptr;
        jobs_.push_back(std::move(job));
    }
    while (!settings_.live && finishing()) step();
}

recording::RecordedRate Recordings::rate() const {
    const std::scoped_lock lock{mutex_};
    return rate_;
}

std::optional<FinishedRun> Recordings::finished() {
    const std::scoped_lock lock{mutex_};
    if (finished_.empty()) return std::nullopt;
    std::optional<FinishedRun> run{std::move(finished_.front())};
    finished_.pop_front();
    return run;
}

bool Recordings::step() {
    ask_for_space();
    if (open_prepared()) return true;
    std::unique_ptr<Job> job;
    std::shared_ptr<recording::Recorder> recording;
    {
        const std::scoped_lock lock{mutex_};
        recording = recording_;
        if (!jobs_.empty()) {
            job = std::move(jobs_.front());
            jobs_.pop_front();
        }
    }
    if (job == nullptr) return recording != nullptr && recording->step();
    conclude(*job);
    job->run.data = job->run.failure && std::filesystem::exists(job->run.file.string() + ".part");
    {
        const std::scoped_lock lock{mutex_};
        finished_.push_back(std::move(job->run));
    }
    job.reset();
    --unfinished_;
    return true;
}

// An exception is stored, so a recording that cannot be finished does not end the program; FILE.part stays.
void Recordings::conclude(Job& job) {
    FinishedRun& f = job.run;
    try {
        f.results = results_of(f.run, job.recording.get());
        if (job.recording != nullptr) {
            run::finish(*job.recording, f.run, f.results);
            const recording::RecordedRate rate = rate_of(f.file, job.lasted_s, f.run.header.pictures);
            const std::scoped_lock lock{mutex_};
            rate_ = rate;
        } else if (!f.run.stops.empty()) {
            f.file = trip_file(settings_.folder, std::chrono::system_clock::now());
            record_tail(f.run, f.results, f.file);
        }
    } catch (const std::exception&) {
        f.failure = std::current_exception();
    }
    if (job.recording != nullptr) f.recorder_failure = job.recording->failure();
    job.recording.reset();
    if (!settings_.on_call) return;
    acquisition::Streams none;
    std::swap(f.run.streams, none);
}

// Runs on the recorder's thread, so a hanging disk does not block the thread that leads the drive.
void Recordings::ask_for_space() {
    const auto now = std::chrono::steady_clock::now();
    if (now < asked_ + space_every) return;
    asked_ = now;
    std::error_code failed;
    const std::filesystem::space_info space = std::filesystem::space(settings_.folder, failed);
    free_bytes_ = failed ? NAN : static_cast<double>(space.available);
}

}  // namespace shaker::run
