#include "daemon/service/event_log.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <utility>

namespace shaker::service {

void EventLog::number(Row& row, double t_s) {
    row.event.number = ++numbers_;
    row.shown_s = t_s;
    row.unseen = false;
}

// A flood is shown at its second, third, fifth, ninth event and so on, and once a second.
void EventLog::repeat(Row& row, double t_s, std::string text) {
    ++row.further;
    row.until_s = t_s;
    row.newest = std::move(text);
    row.unseen = true;
    if (std::has_single_bit(row.further) || t_s - row.shown_s >= flood_s) number(row, t_s);
}

void EventLog::add(double t_s, const std::string& kind, std::string text, std::string key) {
    if (key.empty()) key = text;
    Rows& rows = kinds_[kind];
    if (!rows.empty() && rows.back().key == key && t_s - rows.back().until_s < flood_s)
        return repeat(rows.back(), t_s, std::move(text));
    Row row;
    row.key = key;
    row.event.t_s = row.until_s = t_s;
    row.event.kind = kind;
    row.event.text = std::move(text);
    number(row, t_s);
    row.event.id = row.event.number;
    rows.push_back(std::move(row));
    bound(rows, key);
}

// Removes the second row of the key, because the first has the name and time that matter, or the oldest row.
// The clients have seen the second.
void EventLog::bound(Rows& rows, const std::string& key) {
    const auto alike = [&](const Row& r) { return r.key == key; };
    if (static_cast<std::size_t>(std::ranges::count_if(rows, alike)) > most_alike) {
        const auto first = std::ranges::find_if(rows, alike);
        const auto second = std::find_if(std::next(first), rows.end(), alike);
        first->further += second->further + 1;
        first->until_s = second->until_s;
        first->newest = second->further > 0 ? second->newest : second->event.text;
        rows.erase(second);
    }
    if (rows.size() > most_rows) rows.pop_front();
}

void EventLog::show_counts(double t_s) {
    for (auto& [kind, rows] : kinds_)
        for (Row& row : rows)
            if (row.unseen && t_s - row.shown_s >= flood_s) number(row, t_s);
}

std::string EventLog::text(const Row& row) {
    if (row.further == 0) return row.event.text;
    const double within_s = row.until_s - row.event.t_s;
    if (row.newest == row.event.text)
        return fmt::format("{} ({} more within {:.1f} s)", row.event.text, row.further, within_s);
    return fmt::format("{} ({} more within {:.1f} s, the last: {})", row.event.text, row.further, within_s,
                       row.newest);
}

std::vector<BenchEvent> EventLog::since(std::uint64_t seen) const {
    std::vector<BenchEvent> list;
    for (const auto& [kind, rows] : kinds_)
        for (const Row& row : rows) {
            if (row.event.number <= seen) continue;
            list.push_back(row.event);
            list.back().text = text(row);
        }
    std::ranges::sort(list, {}, &BenchEvent::number);
    return list;
}

}  // namespace shaker::service
