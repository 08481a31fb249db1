#pragma once
// The journal of a campaign: a text file with one JSON object a line. It decides which points are measured
// and to which measurements of which recordings a result belongs, also after a crash.
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "drivers/descriptor.hpp"

namespace shaker::campaign {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// The campaign as a whole begins, pauses, resumes or ends.
struct CampaignChange {
    enum class What { begun, continued, paused, resumed, ended };
    static constexpr std::string_view words[] = {"begun", "continued", "paused", "resumed", "ended"};
    What what = What::begun;
    std::string reason{};  // one sentence; may be empty
    std::string plan{};    // of "begun": SHA-256 of the plan's text
};

/// The set-point of a point is ordered.
struct PointBegun {
    int point = 0;
    /// The passes that the point already has count. Otherwise they are superseded, and the point
    /// is measured again from the start.
    bool keeps_passes = false;
};

/// The measurement of a pass ends: the walker's way along the view, of which a point needs one or several.
struct PassEnded {
    enum class How { complete, early, failed };
    static constexpr std::string_view words[] = {"complete", "early", "failed"};
    int point = 0;
    int pass = 1;             // 1, 2, ... since the point was begun without keeping its passes
    std::string recording{};  // name without ".nxs"
    int measurement = 0;  // its number in the recording; 0: the recording has no finished measurement of it
    double from_s = unknown;  // measured part, s of master time of the recording
    double to_s = unknown;
    double x_from_m = unknown;  // position of the walker when the pass was ordered
    double x_to_m = unknown;    // position of the walker when the pass ended
    double true_v_D = unknown;  // m/s, of a simulated bench
    How how = How::complete;    // all planned periods; only some of them; none
    std::string reason{};       // one sentence; empty for a complete pass
};

/// A pass that the journal has does not count: its recording cannot be read, or the operator wants the point
/// again. A point that was measured must be measured again.
struct PassLost {
    int point = 0;
    int pass = 1;
    std::string reason{};  // one sentence
};

/// The walker was led back: from x_from_m towards x_asked_m; it turned at x_to_m.
struct Returned {
    int point = 0;
    double x_from_m = unknown, x_asked_m = unknown, x_to_m = unknown;
    double for_s = unknown;  // until the next drive was ordered
};

enum class Outcome { measured, failed, left_out };
inline constexpr std::string_view outcome_words[] = {"measured", "failed", "left out"};

struct PointEnded {
    int point = 0;
    Outcome outcome = Outcome::measured;
    std::string reason{};  // one sentence; empty for a measured point
};

struct JournalEntry {
    std::string time{};  // ISO 8601 with offset
    std::variant<CampaignChange, PointBegun, PassEnded, PassLost, PointEnded, Returned> what;
};

/// One line, without its end.
std::string line_of(const JournalEntry& entry);

/// A file to which entries are appended. One thread.
class Journal {
public:
    /// Opens the file, or creates it, and cuts off an incomplete last line. DeviceError when that fails.
    explicit Journal(const std::filesystem::path& file);
    /// Returns when the entry is on the disk. DeviceError when it cannot be written; then the file is as it
    /// was before, and the same entry can be added later.
    void add(const JournalEntry& entry);

private:
    std::filesystem::path file_;
    Descriptor descriptor_;
    std::int64_t whole_ = 0;  // bytes of the complete lines
};

struct ReadJournal {
    std::vector<JournalEntry> entries;
    std::string remark;  // on an incomplete last line, which is dropped; usually empty
};
/// InputError, with the line's number, for a line that is not an entry, except the last one.
ReadJournal read_journal(const std::filesystem::path& file);
/// The same from the text of the file; `file` is its name in messages.
ReadJournal parse_journal(const std::string& text, const std::string& file);

}  // namespace shaker::campaign
