#pragma once
// JournalWriter: brings the events of a campaign to its journal while a drive is led.
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <thread>

#include "daemon/campaign/campaign_folder.hpp"

namespace shaker::campaign {

/// Entries are written in their order. One that the disk refuses is kept and tried again, so none is lost.
/// Thread safety: one thread; the folder belongs to this object meanwhile.
class JournalWriter {
public:
    /// beside: a thread of its own writes, so that a disk that hangs does not hold up the caller.
    JournalWriter(CampaignFolder& folder, bool beside);
    ~JournalWriter();
    JournalWriter(const JournalWriter&) = delete;
    JournalWriter& operator=(const JournalWriter&) = delete;

    void add(decltype(JournalEntry::what) what);
    /// Why the oldest entry is not on the disk; empty when the last attempt was good. Without a thread it
    /// tries again.
    [[nodiscard]] std::string failure();
    /// Returns when all entries are on the disk. DeviceError when one cannot be written.
    void finish();

private:
    void write_all(std::unique_lock<std::mutex>& lock);
    void work(const std::stop_token& stop);

    CampaignFolder& folder_;
    bool beside_;
    std::mutex mutex_;  // guards the members below
    std::condition_variable_any changed_;
    std::deque<decltype(JournalEntry::what)> waiting_;
    std::string failure_;
    std::jthread thread_;
};

}  // namespace shaker::campaign
