#include "daemon/catalogue/catalogue.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include <algorithm>
#include <utility>

#include "daemon/catalogue/quiet_program.hpp"
#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::catalogue {

namespace {

constexpr std::size_t most_bytes = std::size_t{4} << 20U;  // of the summary of a recording
constexpr std::size_t longest_name = 128, longest_line = 300;
constexpr std::chrono::seconds longest_summary{300}, longest_request{1800};
constexpr std::chrono::milliseconds turn{500};
constexpr int differs = 4;  // exit status of replay
constexpr const char *plan_name = "plan.toml", *table_name = "campaign.nxs",
                     *report_name = "report/report.html", *made = "made";

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

// A campaign has a plan in its folder.
std::optional<ListedCampaign> campaign_in(const std::filesystem::directory_entry& place) {
    std::error_code failed;
    ListedCampaign c{.name = place.path().filename().string()};
    if (!listed_name(c.name + ".nxs") || place.is_symlink(failed) ||
        !std::filesystem::is_regular_file(place.path() / plan_name, failed))
        return std::nullopt;
    c.changed = place.last_write_time(failed);
    c.complete = std::filesystem::is_regular_file(place.path() / table_name, failed);
    if (std::filesystem::is_regular_file(place.path() / report_name, failed)) c.report.verdict = made;
    for (const ListedRecording& r : recordings_in(place.path())) {
        if (r.name == table_name) continue;
        ++c.recordings;
        c.bytes += r.bytes;
    }
    return c;
}

std::vector<ListedCampaign> campaigns_in(const std::filesystem::path& folder) {
    std::vector<ListedCampaign> all;
    std::error_code failed;
    for (const auto& place : std::filesystem::directory_iterator{folder, failed})
        if (auto campaign = campaign_in(place)) all.push_back(std::move(*campaign));
    std::ranges::sort(all, std::greater{}, &ListedCampaign::changed);
    if (all.size() > Catalogue::most_campaigns) all.resize(Catalogue::most_campaigns);
    return all;
}

// Without a link in any part of the path.
Descriptor open_below(const std::filesystem::path& folder, const std::filesystem::path& file) {
    Descriptor at{::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)};
    for (const std::filesystem::path& part : file.parent_path())
        at = Descriptor{::openat(at, part.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)};
    return Descriptor{::openat(at, file.filename().c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK)};
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

std::vector<ListedCampaign> Catalogue::campaigns() {
    const std::scoped_lock lock{mutex_};
    asked_ = true;
    return campaigns_;
}

void Catalogue::request(const WantedFile& file) {
    require_rest();
    const std::scoped_lock lock{mutex_};
    Requested* const r = requested(file);
    if (r == nullptr)
        throw InputError{fmt::format("there is no {} \"{}\"", file.report ? "campaign" : "recording",
                                     printable(file.name.substr(0, longest_name)))};
    if (r->verdict == "waiting" || r->verdict == "running") return;
    if (requests_.size() == most_requests)
        throw InputError{fmt::format("{} requests are waiting already; try again later", most_requests)};
    *r = {"waiting", {}};
    requests_.push_back(file);
}

Descriptor Catalogue::open(const WantedFile& file) const {
    const bool listed = listed_name(file.report ? file.name + ".nxs" : file.name);
    Descriptor opened{-1};
    if (listed)
        opened = open_below(settings_.folder, file.report ? std::filesystem::path{file.name} / report_name
                                                          : std::filesystem::path{file.name});
    struct stat now {};
    if (opened >= 0 && ::fstat(opened, &now) == 0 && S_ISREG(now.st_mode)) return opened;
    throw InputError{fmt::format("there is no {} \"{}\"", file.report ? "report of" : "recording",
                                 printable(file.name.substr(0, longest_name)))};
}

bool Catalogue::may_go_on(const std::stop_token& stop) const {
    return !stop.stop_requested() && settings_.may_read();
}

Catalogue::Entry* Catalogue::entry(const std::string& name) {
    const auto found = std::ranges::find_if(entries_, [&](const Entry& e) { return e.listed.name == name; });
    return found == entries_.end() ? nullptr : &*found;
}

Requested* Catalogue::requested(const WantedFile& file) {
    if (Entry* const e = file.report ? nullptr : entry(file.name)) return &e->listed.replay;
    const auto found = std::ranges::find(campaigns_, file.name, &ListedCampaign::name);
    return file.report && found != campaigns_.end() ? &found->report : nullptr;
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
            if (serve_next(stop) || read_next(stop)) continue;
        }
        std::unique_lock lock{mutex_};
        more_.wait_for(lock, stop, turn, [] { return false; });
    }
}

// An entry stays until its file changes.
void Catalogue::scan(bool first) {
    std::vector<ListedRecording> now = recordings_in(settings_.folder);
    std::vector<ListedCampaign> campaigns = campaigns_in(settings_.folder);
    const std::scoped_lock lock{mutex_};
    for (ListedCampaign& c : campaigns)
        if (const Requested* const r = requested({c.name, true}); r != nullptr && !r->verdict.empty())
            c.report = *r;
    campaigns_ = std::move(campaigns);
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

// As read_next(). A request that the drive has ended waits again.
bool Catalogue::serve_next(const std::stop_token& stop) {
    WantedFile file;
    const auto tell = [&](const char* verdict, const std::string& text) {
        const std::scoped_lock lock{mutex_};
        if (Requested* const r = requested(file)) *r = {verdict, text};
    };
    {
        const std::scoped_lock lock{mutex_};
        if (requests_.empty()) return false;
        file = requests_.front();
    }
    tell("running", {});
    try {
        const auto end = run_quietly({.words = {settings_.program.string(), file.report ? "report" : "replay",
                                                (settings_.folder / file.name).string()},
                                      .most_bytes = most_bytes,
                                      .longest = longest_request},
                                     [&] { return may_go_on(stop); });
        if (!end) return tell("waiting", "the drive was started"), false;
        const bool told = end->status == 0 || (end->status == differs && !file.report);
        if (end->late)
            tell("failed", "it takes too long");
        else
            tell(!told              ? "failed"
                 : file.report      ? made
                 : end->status == 0 ? "identical"
                                    : "differs",
                 last_line(told ? end->out : end->err));
    } catch (const std::exception& e) {
        tell("failed", e.what());
    }
    const std::scoped_lock lock{mutex_};
    requests_.pop_front();
    return true;
}

}  // namespace shaker::catalogue
