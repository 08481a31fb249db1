#pragma once
// The recordings of a folder, read by confined processes at idle priority, and only while nothing is driven.
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/catalogue/recording_summary.hpp"
#include "daemon/catalogue/results_table.hpp"
#include "drivers/descriptor.hpp"

namespace shaker::catalogue {

struct CatalogueSettings {
    std::filesystem::path folder;
    std::filesystem::path program = "/proc/self/exe";  // shakerd, started for each file
    std::function<bool()> may_read;  // false while the drive is on: a process is killed then. Any thread
};

/// Progress and end of a replay, or of the making of a report.
struct Requested {
    /// "waiting", "running", "failed"; "identical" or "differs", "made"; empty: not requested.
    std::string verdict;
    std::string text;  // last line of its output
};

struct ListedRecording {
    std::string name;          // of the file
    std::uintmax_t bytes = 0;  // without its pictures
    std::filesystem::file_time_type changed{};
    std::optional<RecordingSummary> summary{};  // without rows; empty: not read yet, or not readable
    std::vector<Drive> set_points{};            // different ones, at most most_set_points
    std::string trouble{};                      // reason why it could not be read
    Requested replay{};
};

/// A folder of a campaign.
struct ListedCampaign {
    std::string name;
    std::uintmax_t bytes = 0;  // of its recordings, without pictures
    std::size_t recordings = 0;
    bool complete = false;  // its points table is written
    std::filesystem::file_time_type changed{};
    Requested report{};
};

/// True for the names that the list has: letters, digits, dots, hyphens, underscores; NAME.nxs.
bool listed_name(const std::string& name) noexcept;

/// A file for download: a recording NAME.nxs, or the report of a campaign.
struct WantedFile {
    std::string name;
    bool report = false;
};

/// Thread safety: all functions on any thread, none waits for the disk except open(); a thread of its own
/// reads.
class Catalogue {
public:
    static constexpr std::size_t most_listed = 500;        // the newest files
    static constexpr std::size_t most_results_read = 200;  // recordings of before whose results are read
    static constexpr std::size_t most_set_points = 8, most_requests = 8;
    static constexpr std::size_t most_campaigns = 100;  // the newest folders

    /// Begins to read the results of the newest recordings into `results`, which must outlive this object.
    Catalogue(CatalogueSettings settings, ResultsTable& results);
    ~Catalogue();
    Catalogue(const Catalogue&) = delete;
    Catalogue& operator=(const Catalogue&) = delete;

    /// True when the results of the recordings of before are in the table, as far as they could be read.
    [[nodiscard]] bool complete() const;
    /// The recordings, the newest first, as far as they are known. Requests that the folder is read again.
    [[nodiscard]] std::vector<ListedRecording> list();
    /// The campaigns, as list().
    [[nodiscard]] std::vector<ListedCampaign> campaigns();
    /// Requests a replay, or the report of a campaign. InputError: unknown name, too many requests, or the
    /// drive is on.
    void request(const WantedFile& file);
    /// InputError with the reason while recordings may not be read.
    void require_rest() const;
    /// Opens a file of the folder for reading. Links are not followed. InputError when there is none of this
    /// name.
    [[nodiscard]] Descriptor open(const WantedFile& file) const;

private:
    struct Entry {
        ListedRecording listed;
        bool before = false;  // its results belong to the table
        bool read = false;
    };
    void work(const std::stop_token& stop);
    [[nodiscard]] bool may_go_on(const std::stop_token& stop) const;
    void scan(bool first);
    bool read_next(const std::stop_token& stop);
    bool serve_next(const std::stop_token& stop);
    Entry* entry(const std::string& name);
    Requested* requested(const WantedFile& file);

    CatalogueSettings settings_;
    ResultsTable& results_;
    mutable std::mutex mutex_;  // guards all below; held briefly
    std::condition_variable_any more_;
    std::vector<Entry> entries_;             // the newest first
    std::vector<ListedCampaign> campaigns_;  // the newest first
    std::deque<WantedFile> requests_;
    bool scanned_ = false, asked_ = false;
    std::jthread thread_;
};

}  // namespace shaker::catalogue
