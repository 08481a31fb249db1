#include "daemon/catalogue/results_table.hpp"

#include <algorithm>

namespace shaker::catalogue {

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
