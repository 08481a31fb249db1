#pragma once
// The folder of a campaign: plan.toml, journal.jsonl, recordings NAME.nxs, and the points table campaign.nxs.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/campaign/journal.hpp"
#include "daemon/campaign/progress.hpp"
#include "drivers/recorded/h5/file_lock.hpp"

namespace shaker::campaign {

inline constexpr const char* plan_name = "plan.toml";
inline constexpr const char* journal_name = "journal.jsonl";
inline constexpr const char* table_name = "campaign.nxs";

/// What a folder has of a campaign, without its recordings.
struct StoredCampaign {
    std::string plan;                   // text of plan.toml
    std::vector<JournalEntry> entries;  // of the journal
    Progress progress;                  // that follows from them
    std::string remark;                 // on an incomplete last line of the journal; usually empty
};
/// Reads a folder. InputError for a folder without a campaign, a plan that was changed after the campaign had
/// begun, and an error in the journal.
StoredCampaign read_campaign(const std::filesystem::path& folder);

/// A campaign that stopped before its end: the program or the machine ended in it.
struct InterruptedCampaign {
    std::filesystem::path folder;
    std::string title;                  // of the plan
    std::size_t points = 0, ended = 0;  // of the plan; that need no further measurement
};
/// The newest campaign in the folders of `recordings`, if it has not ended and no process leads it. A
/// campaign that cannot be read does not count: its own error is reported where it is opened.
std::optional<InterruptedCampaign> newest_interrupted(const std::filesystem::path& recordings);

/// Creates the folder if it is missing. InputError for a folder that has anything in it but the lock of a
/// daemon's recordings.
void prepare_folder(const std::filesystem::path& folder);

/// A folder that is open for measuring. The lock on its journal ends with this object, or with the process.
class CampaignFolder {
public:
    /// Creates the folder, if it is missing, and the files of a campaign that has not measured anything.
    /// InputError for a folder that is not empty; DeviceError when the disk fails.
    static CampaignFolder begin(const std::filesystem::path& folder, const std::string& plan);
    /// Opens the folder of a campaign that was interrupted, or ended, to continue it. InputError as
    /// read_campaign(), when `plan` is given and is another text, and when another process measures into the
    /// folder.
    static CampaignFolder continued(const std::filesystem::path& folder,
                                    const std::optional<std::string>& plan = std::nullopt);

    /// Adds an entry with the present time; returns when it is on the disk. DeviceError when it cannot be
    /// written. What a reader would remark is logged; what it would refuse is logged and not written.
    void add(decltype(JournalEntry::what) what);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
    /// Plan, entries and remark as they were when the folder was opened.
    [[nodiscard]] const StoredCampaign& stored() const noexcept { return stored_; }

private:
    CampaignFolder(std::filesystem::path path, h5::FileLock lock, StoredCampaign stored);

    std::filesystem::path path_;
    h5::FileLock lock_;
    StoredCampaign stored_;
    Follower follower_;  // of all entries in the file
    Journal journal_;
};

}  // namespace shaker::campaign
