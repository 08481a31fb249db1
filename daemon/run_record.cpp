#include "daemon/run_record.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "daemon/desk.hpp"
#include "daemon/drive_rig.hpp"
#include "daemon/identification_record.hpp"
#include "daemon/results.hpp"
#include "daemon/run_setup.hpp"
#include "daemon/stopped_run.hpp"
#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr std::size_t longest_name = 64;

std::string stem_now() {
    const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    return fmt::format("run-{:%Y%m%dT%H%M%SZ}", fmt::gmtime(now));
}

// A daemon's devices count from its start, a recording from its own.
std::vector<DeviceReport> lost_since(const std::vector<DeviceReport>& before, std::vector<DeviceReport> now) {
    for (std::size_t i = 0; i < now.size() && i < before.size(); ++i) {
        DeviceCounts& c = now[i].counts;
        const DeviceCounts& b = before[i].counts;
        c = {c.taken - b.taken, c.lost - b.lost, c.incidents - b.incidents, c.reopened - b.reopened};
    }
    return now;
}

bool is_utf8(const std::string& text) {
    return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::ignore) ==
           nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// A recording that cannot be finished must not end the daemon: it says why, and FILE.part stays.
template <class Finish>
std::string said(const std::filesystem::path& file, Finish finish) try {
    return finish();
} catch (const std::exception& e) {
    return fmt::format("{} could not be finished: {}; \"shakerd recover {}\" makes a file of what is there",
                       file.string(), e.what(), file.string());
}

}  // namespace

void require_name(const std::string& name) {
    constexpr std::string_view more = "._-";
    const auto allowed = [&](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               more.find(c) != std::string_view::npos;
    };
    if (!name.empty() && name.size() <= longest_name && name.front() != '.' &&
        std::ranges::all_of(name, allowed))
        return;
    throw InputError{
        fmt::format("recording \"{}\": a name of 1 to {} letters, digits, dots, hyphens and underscores that "
                    "does not begin with a dot was expected",
                    name.substr(0, longest_name), longest_name)};
}

void require_remark(const std::string& text) {
    const bool plain =
        std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) >= ' ' && c != '\x7f'; });
    if (!text.empty() && text.size() <= Remark::longest && plain && is_utf8(text)) return;
    throw InputError{
        fmt::format("remark of {} bytes: 1 to {} bytes of UTF-8 without control characters are "
                    "allowed",
                    text.size(), Remark::longest)};
}

void RunRecord::remark(const std::string& text, const Director& director) {
    const LogEntry entry{director.now_s(), name(director.state()), "remark: " + text};
    if (on()) return recording_->add(entry);
    if (remarks_.size() == most_remarks) remarks_.pop_front();
    remarks_.push_back(entry);
}

void RunRecord::begin(const RunOptions& run, bool record, const std::string& name) {
    header_ = run_header(bench_, run, settings_.live, false);
    before_ = device_reports(bench_.rig);
    if (!record) return;
    if (run.pictures != KeptPictures::off) header_.views = acquisition_.views_now();
    open(name);
    if (run.pictures != KeptPictures::off) acquisition_.learn_anew(header_.views);
}

void RunRecord::open(const std::string& name) {
    std::string stem = name;
    if (stem.empty()) {
        const std::string now = stem_now();
        stem = now;
        for (int k = 2; std::filesystem::exists(settings_.folder / (stem + ".nxs")); ++k)
            stem = fmt::format("{}-{}", now, k);
    }
    require_name(stem);
    file_ = settings_.folder / (stem + ".nxs");
    auto recording = std::make_unique<Recording>(file_, header_, RecordingSettings{.live = settings_.live});
    const std::scoped_lock lock{mutex_};
    recording_ = std::move(recording);
    watch_ = std::make_unique<RecordingWatch>(*recording_);
    for (const LogEntry& remark : remarks_) recording_->add(remark);
    remarks_.clear();
    acquisition_.record(recording_.get());
    begun_s_ = INFINITY;
    told_long_ = false;
}

RecordingState RunRecord::state() const {
    std::error_code failed;
    const std::filesystem::space_info space = std::filesystem::space(settings_.folder, failed);
    RecordingState s;
    s.free_bytes = failed ? NAN : static_cast<double>(space.available);
    if (!on()) return s;
    s.name = file_.filename().string();
    s.backlog = recording_->backlog();
    s.pieces_lost = recording_->lost();
    return s;
}

void RunRecord::look(Director& director, Lanes& lanes) {
    if (!on()) return;
    begun_s_ = std::min(begun_s_, director.now_s());
    watch_->look(director, acquisition_.take(), lanes);
    if (director.now_s() < begun_s_ + settings_.most_s || told_long_) return;
    if (const RunState s = director.state(); s != RunState::ramp && s != RunState::run) return;
    told_long_ = true;
    director.end(lanes);
}

bool RunRecord::step() {
    const std::scoped_lock lock{mutex_};
    return recording_ != nullptr && recording_->step();
}

void RunRecord::close() {
    acquisition_.record(nullptr);
    const std::scoped_lock lock{mutex_};
    watch_.reset();
    recording_.reset();
}

std::string RunRecord::finish(const Director& director) {
    if (!on()) return {};
    std::string what = said(file_, [&] {
        const std::scoped_lock lock{mutex_};
        const Take& take = acquisition_.take();
        if (const auto& found = director.keeper().identified())
            write_identification(recording_->writer(), *found);
        try {
            if (director.measured().empty()) throw InputError{"no measurement was complete"};
            const MeasuredPart part = director.measured().back();
            Reduction r = reduce(measurement_of(take, header_.frequency_hz, part.from_s, part.to_s));
            std::ranges::move(notes_on(take), std::back_inserter(r.notes));
            std::ranges::move(notes_on(lost_since(before_, device_reports(bench_.rig))),
                              std::back_inserter(r.notes));
            std::ranges::copy(director.notes(), std::back_inserter(r.notes));
            recording_->finish(take, r, part.from_s, part.to_s);
        } catch (const InputError& e) {
            recording_->writer().text("process/not_reduced", e.what());
            recording_->finish(take);
        }
        return "recorded: " + file_.string();
    });
    close();
    return what;
}

std::string RunRecord::finish_stopped(const Director& director) {
    const bool measuring = director.stops().at(director.cause()).measuring;
    const DriveKeeper& keeper = director.keeper();
    const Take& take = acquisition_.take();
    const StoppedRun run{
        .header = header_,
        .take = take,
        .tails = acquisition_.tails(),
        .trips = recorded_trips(take, director),
        .planned = measuring ? MeasuredPart{director.from_s(), director.to_s()} : MeasuredPart{},
        .identified = keeper.identified() ? &*keeper.identified() : keeper.found()};
    if (on()) {
        std::string what = said(file_, [&] {
            const std::scoped_lock lock{mutex_};
            shaker::finish(*recording_, run);
            return "recorded: " + file_.string();
        });
        close();
        return what;
    }
    const std::filesystem::path file = trip_file(settings_.folder, std::chrono::system_clock::now());
    return said(file, [&] {
        record_tail(run, file);
        return fmt::format("its last {} s: {}", tail_s, file.string());
    });
}

}  // namespace shaker
