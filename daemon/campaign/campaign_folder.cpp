#include "daemon/campaign/campaign_folder.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <span>
#include <system_error>
#include <utility>

#include "daemon/campaign/plan.hpp"
#include "daemon/recording/folder.hpp"
#include "daemon/recording/time_text.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/disk_file.hpp"
#include "drivers/text/sha256.hpp"

namespace shaker::campaign {

namespace {

namespace fs = std::filesystem;

h5::FileLock locked(const fs::path& folder) {
    const fs::path journal = folder / journal_name;
    if (auto lock = h5::FileLock::take(journal, true)) return std::move(*lock);
    throw InputError{
        fmt::format("{}: process {} leads a campaign in this folder; end it, or choose another folder",
                    folder.string(), h5::locked_by(journal).value_or(0))};
}

void create(const fs::path& folder) {
    std::error_code error;
    if (fs::create_directories(folder, error); error)
        throw InputError{
            fmt::format("{}: the folder cannot be created: {}", folder.string(), error.message())};
}

}  // namespace

std::optional<InterruptedCampaign> newest_interrupted(const fs::path& recordings) try {
    fs::path newest;
    fs::file_time_type newest_time;
    for (const fs::directory_entry& entry : fs::directory_iterator{recordings}) {
        std::error_code missing;
        const fs::file_time_type time = fs::last_write_time(entry.path() / journal_name, missing);
        if (missing || (!newest.empty() && time <= newest_time)) continue;
        newest = entry.path();
        newest_time = time;
    }
    if (newest.empty() || h5::locked_by(newest / journal_name)) return std::nullopt;
    const StoredCampaign stored = read_campaign(newest);
    const auto& change = stored.progress.campaign;
    if (!change || change->what == CampaignChange::What::ended) return std::nullopt;
    const Plan plan = parse_plan(stored.plan, (newest / plan_name).string());
    InterruptedCampaign found{.folder = newest, .title = plan.title};
    for (const Point& point : schedule(plan, most_stored_points)) {
        ++found.points;
        if (stored.progress.done(point.id)) ++found.ended;
    }
    return found;
} catch (const std::exception&) {
    return std::nullopt;
}

void prepare_folder(const fs::path& folder) {
    create(folder);
    const auto unexpected = [](const fs::directory_entry& entry) {
        return entry.path().filename() != recording::folder_lock_name;
    };
    if (std::none_of(fs::directory_iterator{folder}, {}, unexpected)) return;
    if (fs::exists(folder / plan_name))
        throw InputError{fmt::format(
            "{}: has a campaign already; continue it (--continue), or choose a new folder", folder.string())};
    throw InputError{
        fmt::format("{}: is not empty; a campaign needs a new or empty folder", folder.string())};
}

StoredCampaign read_campaign(const fs::path& folder) {
    std::ifstream in{folder / plan_name, std::ios::binary};
    if (!in)
        throw InputError{
            fmt::format("{}: not the folder of a campaign: it has no {}", folder.string(), plan_name)};
    StoredCampaign stored;
    stored.plan = {std::istreambuf_iterator<char>{in}, {}};
    ReadJournal journal = read_journal(folder / journal_name);
    stored.entries = std::move(journal.entries);
    stored.remark = std::move(journal.remark);
    try {
        stored.progress = progress_of(stored.entries);
    } catch (const InputError& e) {
        throw InputError{fmt::format("{}, {}", (folder / journal_name).string(), e.what())};
    }
    if (!stored.progress.plan.empty() && stored.progress.plan != text::sha256(stored.plan))
        throw InputError{
            fmt::format("{}: was changed after the campaign had begun; restore its text, or measure the "
                        "changed plan in a new folder",
                        (folder / plan_name).string())};
    return stored;
}

CampaignFolder::CampaignFolder(fs::path path, h5::FileLock lock, StoredCampaign stored)
    : path_{std::move(path)},
      lock_{std::move(lock)},
      stored_{std::move(stored)},
      journal_{path_ / journal_name} {
    for (const JournalEntry& entry : stored_.entries) follower_(entry);
}

CampaignFolder CampaignFolder::begin(const fs::path& folder, const std::string& plan) {
    prepare_folder(folder);
    h5::FileLock lock = locked(folder);
    h5::replace_file(folder / plan_name, std::as_bytes(std::span{plan}));
    CampaignFolder made{folder, std::move(lock), {plan, {}, {}, {}}};
    made.add(CampaignChange{CampaignChange::What::begun, {}, text::sha256(plan)});
    h5::sync_folder(folder);
    return made;
}

CampaignFolder CampaignFolder::continued(const fs::path& folder, const std::optional<std::string>& plan) {
    if (!fs::exists(folder / plan_name)) read_campaign(folder);  // refuses before a lock is made
    h5::FileLock lock = locked(folder);
    StoredCampaign stored = read_campaign(folder);
    if (plan && *plan != stored.plan)
        throw InputError{
            fmt::format("{}: the campaign in this folder has another plan; continue it without a plan, or "
                        "measure this plan in a new folder",
                        folder.string())};
    const bool begun = !stored.progress.plan.empty();
    CampaignFolder opened{folder, std::move(lock), std::move(stored)};
    if (begun)
        opened.add(CampaignChange{CampaignChange::What::continued, {}, {}});
    else  // its process ended while it created the folder
        opened.add(CampaignChange{CampaignChange::What::begun, {}, text::sha256(opened.stored_.plan)});
    return opened;
}

void CampaignFolder::add(decltype(JournalEntry::what) what) {
    const JournalEntry entry{recording::local_time_text(), std::move(what)};
    Follower reader = follower_;
    try {
        reader(entry);
    } catch (const InputError& e) {
        spdlog::error("{}: {}; it is not written", (path_ / journal_name).string(), e.what());
        return;
    }
    journal_.add(entry);
    for (std::size_t i = follower_.progress().remarks.size(); i < reader.progress().remarks.size(); ++i)
        spdlog::warn("{}, {}", (path_ / journal_name).string(), reader.progress().remarks[i]);
    follower_ = std::move(reader);
}

}  // namespace shaker::campaign
