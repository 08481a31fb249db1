#include "daemon/catalogue/catalogue.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <utility>

#include "daemon/catalogue/quiet_program.hpp"
#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::catalogue {

namespace {

constexpr std::size_t most_bytes = std::size_t{4} << 20U;  // of the summary of a recording
constexpr std::size_t longest_name = 128, longest_line = 300;
constexpr std::chrono::seconds longest_summary{300}, longest_replay{1800};
constexpr std::chrono::milliseconds turn{500};
constexpr int differs = 4;  // exit status of replay

std::vector<ListedRecording> recordings_in(const std::filesystem::path& folder) {
    std::vector<ListedRecording> all;
    std::error_code failed;
    for (const auto& file : std::filesystem::directory_iterator{folder, failed}) {
        const std::string name = file.path().filename().string();
        struct stat now {};
        if (!listed_name(name) || ::lstat(file.path().c_str(), &now) < 0 || !S_ISREG(now.st_mode)) continue;
        std::error_code gone;
        const auto changed = file.last_write_time(gone);
        if (!gone)
            all.push_back(
                {.name = name, .bytes = static_cast<std::uintmax_t>(now.st_size), .changed = changed});
    }
    std::ranges::sort(all, std::greater{}, &ListedRecording::changed);
    if (all.size() > Catalogue::most_listed) all.resize(Catalogue::most_listed);
    return all;
}

std::vector<Drive> set_points_of(const std::vector<ResultRow>& rows) {
    std::vector<Drive> all;
    for (const ResultRow& row : rows) {
        if (!row.asked || all.size() == Catalogue::most_set_points) continue;
        if (std::ranges::find(all, *row.asked) == all.end()) all.push_back(*row.asked);
    }
    return all;
}

// The last line that has characters, made printable.
std::string last_line(const std::string& text) {
    const std::size_t end = text.find_last_not_of(" \n");
    if (end == std::string::npos) return {};
    const std::size_t begin = text.rfind('\n', end) + 1;
    return printable(text.substr(begin, std::min(end + 1 - begin, longest_line)));
}

}  // namespace

bool listed_name(const std::string& name) noexcept {
    const auto allowed = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
               c == '_' || c == '-';
    };
    return name.size() <= longest_name && name.ends_with(".nxs") && name.front() != '.' &&
           std::ranges::all_of(name, allowed);
}

Catalogue::Catalogue(CatalogueSettings settings, ResultsTable& results)
    : settings_{std::move(settings)}, results_{results}, thread_{[this](const std::stop_token& stop) {
          work(stop);
      }} {}

Catalogue::~Catalogue() {
    thread_.request_stop();
    thread_.join();
}

bool Catalogue::complete() const {
    const std::scoped_lock lock{mutex_};
    return scanned_ && std::ranges::all_of(entries_, [](const Entry& e) { return e.read || !e.before; });
}

std::vector<ListedRecording> Catalogue::list() {
    const std::scoped_lock lock{mutex_};
    asked_ = true;
    std::vector<ListedRecording> all;
    for (const Entry& e : entries_) all.push_back(e.listed);
    return all;
}

void Catalogue::require_rest() const {
    if (!settings_.may_read())
        throw InputError{
            "recordings are read only while nothing is driven or finished; stop the drive, or wait, then try "
            "again"};
}

void Catalogue::replay(const std::string& name) {
    require_rest();
    const std::scoped_lock lock{mutex_};
    Entry* const e = entry(name);
    if (e == nullptr) throw InputError{fmt::format("there is no recording \"{}\"", printable(name))};
    if (std::ranges::find(replays_, name) != replays_.end()) return;
    if (replays_.size() == most_replays)
        throw InputError{fmt::format("{} replays are waiting already; try again later", most_replays)};
    e->listed.replay = {"waiting", {}};
    replays_.push_back(name);
}

Descriptor Catalogue::open(const std::string& name) const {
    Descriptor file{listed_name(name) ? ::open((settings_.folder / name).c_str(),
                                               O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK)
                                      : -1};
    struct stat now {};
    if (file >= 0 && ::fstat(file, &now) == 0 && S_ISREG(now.st_mode)) return file;
    throw InputError{fmt::format("there is no recording \"{}\"", printable(name.substr(0, longest_name)))};
}

bool Catalogue::may_go_on(const std::stop_token& stop) const {
    return !stop.stop_requested() && settings_.may_read();
}

Catalogue::Entry* Catalogue::entry(const std::string& name) {
    const auto found = std::ranges::find_if(entries_, [&](const Entry& e) { return e.listed.name == name; });
    return found == entries_.end() ? nullptr : &*found;
}

void Catalogue::work(const std::stop_token& stop) {
    static_cast<void>(name_thread("catalogue"));
    scan(true);
    while (!stop.stop_requested()) {
        bool asked = false;
        {
            std::unique_lock lock{mutex_};
            asked = std::exchange(asked_, false);
        }
        if (may_go_on(stop)) {
            if (asked) scan(false);
            if (replay_next(stop) || read_next(stop)) continue;
        }
        std::unique_lock lock{mutex_};
        more_.wait_for(lock, stop, turn, [] { return false; });
    }
}

// An entry stays until its file changes.
void Catalogue::scan(bool first) {
    std::vector<ListedRecording> now = recordings_in(settings_.folder);
    const std::scoped_lock lock{mutex_};
    std::vector<Entry> entries;
    for (ListedRecording& file : now) {
        Entry* const known = entry(file.name);
        if (known != nullptr && known->listed.changed == file.changed && known->listed.bytes == file.bytes)
            entries.push_back(std::move(*known));
        else
            entries.push_back(
                {.listed = std::move(file), .before = first && entries.size() < most_results_read});
    }
    entries_ = std::move(entries);
    scanned_ = true;
}

// False when nothing is to be read, or when the drive has started meanwhile.
bool Catalogue::read_next(const std::stop_token& stop) {
    std::string name;
    {
        const std::scoped_lock lock{mutex_};
        const auto next = std::ranges::find(entries_, false, &Entry::read);
        if (next == entries_.end()) return false;
        name = next->listed.name;
    }
    RecordingSummary summary;
    std::string trouble;
    try {
        const auto end = run_quietly(
            {.words = {settings_.program.string(), "list", "--json", (settings_.folder / name).string()},
             .most_bytes = most_bytes,
             .longest = longest_summary},
            [&] { return may_go_on(stop); });
        if (!end) return false;
        if (end->status != 0) throw InputError{end->late ? "reading takes too long" : last_line(end->err)};
        summary = summary_from(end->out);
    } catch (const std::exception& e) {
        trouble = e.what();
    }
    const std::scoped_lock lock{mutex_};
    Entry& e = *entry(name);  // only this thread removes entries
    e.read = true;
    e.listed.trouble = trouble;
    if (!trouble.empty()) return true;
    if (e.before) results_.add(summary.rows);
    e.listed.set_points = set_points_of(summary.rows);
    summary.rows.clear();
    e.listed.summary = std::move(summary);
    return true;
}

// As read_next(). A replay that the drive has ended waits again.
bool Catalogue::replay_next(const std::stop_token& stop) {
    std::string name;
    const auto tell = [&](const char* verdict, const std::string& text) {
        const std::scoped_lock lock{mutex_};
        if (Entry* const e = entry(name)) e->listed.replay = {verdict, text};
    };
    {
        const std::scoped_lock lock{mutex_};
        if (replays_.empty()) return false;
        name = replays_.front();
    }
    tell("running", {});
    try {
        const auto end =
            run_quietly({.words = {settings_.program.string(), "replay", (settings_.folder / name).string()},
                         .most_bytes = most_bytes,
                         .longest = longest_replay},
                        [&] { return may_go_on(stop); });
        if (!end) return tell("waiting", "the drive was started"), false;
        if (end->late)
            tell("failed", "the replay takes too long");
        else
            tell(end->status == 0         ? "identical"
                 : end->status == differs ? "differs"
                                          : "failed",
                 last_line(end->status == 0 || end->status == differs ? end->out : end->err));
    } catch (const std::exception& e) {
        tell("failed", e.what());
    }
    const std::scoped_lock lock{mutex_};
    replays_.pop_front();
    return true;
}

}  // namespace shaker::catalogue
