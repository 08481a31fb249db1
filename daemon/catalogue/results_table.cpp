#include "daemon/catalogue/results_table.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>

namespace shaker::catalogue {

namespace {

std::string end_of(const ResultRow& row, int periods) {
    if (periods == 0 || row.periods >= periods) return "complete";
    return fmt::format("ended after {:.0f} of {} periods", row.periods, periods);
}

}  // namespace

ResultRow row_of(const recording::FinishedMeasurement& finished, const reduction::Reduction* reduction,
                 const std::string& not_reduced, int periods) {
    ResultRow row;
    row.asked = finished.asked;
    row.periods = std::round((finished.part.to_s - finished.part.from_s) * finished.asked.frequency);
    row.ended = reduction != nullptr ? end_of(row, periods) : "no result: " + not_reduced;
    if (reduction == nullptr) return row;
    const reduction::Reduction& r = *reduction;
    for (const ListedQuantity& l : listed_quantities) row.*l.member = l.quantity.of(r);
    row.steady = !std::isfinite(r.v_D_settled.value) && !r.degraded;
    row.notes = fmt::format("{}", fmt::join(r.notes, "; "));
    return row;
}

ResultRow interrupted_row(const std::optional<Drive>& asked, const std::string& why) {
    ResultRow row;
    row.asked = asked;
    row.ended = why;
    return row;
}

void ResultsTable::add(const std::vector<ResultRow>& rows) {
    const std::scoped_lock lock{mutex_};
    for (const ResultRow& row : rows) {
        const auto later = std::ranges::upper_bound(
            rows_, row.time, {}, [](const NumberedRow& r) -> const std::string& { return r.row.time; });
        rows_.insert(later, {++numbers_, row});
        if (rows_.size() > most_rows) rows_.erase(rows_.begin());
    }
}

std::vector<NumberedRow> ResultsTable::since(std::uint64_t seen) const {
    const std::scoped_lock lock{mutex_};
    std::vector<NumberedRow> newer;
    std::ranges::copy_if(rows_, std::back_inserter(newer),
                         [seen](const NumberedRow& r) { return r.number > seen; });
    return newer;
}

std::uint64_t ResultsTable::newest() const {
    const std::scoped_lock lock{mutex_};
    return numbers_;
}

}  // namespace shaker::catalogue
