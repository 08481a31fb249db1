#pragma once
// What the journal of a campaign says about its points.
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/campaign/journal.hpp"

namespace shaker::campaign {

struct PointProgress {
    int begun = 0;                    // number of times that it was begun without keeping its passes
    std::vector<PassEnded> passes{};  // those that count, in their order
    int superseded = 0;               // passes with a measurement that do not count any more
    std::optional<PointEnded> ended;  // empty: in progress
};

struct Progress {
    std::map<int, PointProgress> points;     // those that were begun or left out, by number
    std::optional<CampaignChange> campaign;  // the newest change
    std::string plan;                        // SHA-256 of the text of the plan; empty: not begun
    /// One sentence for each doubled or late entry, with its number. Usually empty.
    std::vector<std::string> remarks;
    /// True when the point needs no further measurement: it was measured, failed for good, or was left out.
    [[nodiscard]] bool done(int point) const;
};

/// Follows the entries of a journal, one by one.
///
/// Hours of recordings must not depend on one line: an entry that cannot follow those before it is a remark,
/// and the last word counts. When two entries are for one pass, or for one measurement, the later one with a
/// measurement counts. An entry for a point that is not in progress changes nothing but an outcome: a point
/// is measured only while it has a measurement. Only what makes it the journal of another campaign is
/// refused.
class Follower {
public:
    /// InputError, with the number of the entry: the campaign has not begun, or begins again.
    void operator()(const JournalEntry& entry);
    [[nodiscard]] const Progress& progress() const noexcept { return out_; }

private:
    struct Count;  // what one kind of entry says
    Progress out_;
    std::size_t number_ = 0;
};

/// Follows all entries. InputError as Follower.
Progress progress_of(std::span<const JournalEntry> entries);

}  // namespace shaker::campaign
