#pragma once
// EventLog: the remembered events of the bench, in bounded memory. A flood of events of one kind, or of equal
// events, leaves the others in it.
#include <cstdint>
#include <list>
#include <map>
#include <string>
#include <vector>

namespace shaker::service {

/// A row of the log for all clients.
struct BenchEvent {
    std::uint64_t number = 0;  // counts from 1; a row that was changed has a new number
    std::uint64_t id = 0;      // its first number
    double t_s = 0;            // master time of the first event of the row
    /// "state", "note", "trip", "order", "setting", "campaign", "remark", "warning" or "settings".
    std::string kind;
    std::string text;  // of the first event; then the number of further ones, with their times
};

class EventLog {
public:
    static constexpr std::size_t most_rows = 60;  // of each kind
    static constexpr std::size_t most_alike = 8;  // rows with one key
    /// Consecutive alike events at smaller distances share a row; master time.
    static constexpr double flood_s = 1;

    /// t_s: master time, s. key: events of one kind and key are alike; empty: the text. When there are more
    /// than most_alike rows of a key, the first and the newest remain, and the first has the count.
    void add(double t_s, const std::string& kind, std::string text, std::string key = {});
    /// Gives new numbers to rows whose count has changed unseen. Call it about ten times a second.
    void show_counts(double t_s);
    /// Rows with a number above `seen`, in order of their numbers.
    [[nodiscard]] std::vector<BenchEvent> since(std::uint64_t seen) const;

private:
    struct Row {
        BenchEvent event;
        std::string key;
        std::string newest;         // text of the newest further event
        std::uint64_t further = 0;  // events in this row after the first
        double until_s = 0;         // time of the newest
        double shown_s = 0;         // time of the newest number
        bool unseen = false;        // the count has changed since
    };
    using Rows = std::list<Row>;

    void repeat(Row& row, double t_s, std::string text);
    void number(Row& row, double t_s);
    static void bound(Rows& rows, const std::string& key);
    [[nodiscard]] static std::string text(const Row& row);

    std::map<std::string, Rows> kinds_;
    std::uint64_t numbers_ = 0;
};

}  // namespace shaker::service
