#pragma once
// What the journal of a campaign says about its points.
#include <map>
#include <optional>
#include <span>

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
    /// True when the point needs no further measurement: it was measured, failed for good, or was left out.
    [[nodiscard]] bool done(int point) const;
};

/// Follows the entries. InputError, with the number of the entry, for an entry that cannot follow those
/// before it: a pass of a point that is not in progress, a pass or a measurement that was counted already, a
/// point that is begun although it was measured.
Progress progress_of(std::span<const JournalEntry> entries);

}  // namespace shaker::campaign
