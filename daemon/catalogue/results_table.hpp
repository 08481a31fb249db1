#pragma once
// The newest measurements of a bench: those of the present daemon, and those of its recordings of before.
#include <cstdint>
#include <mutex>
#include <vector>

#include "daemon/catalogue/result_row.hpp"

namespace shaker::catalogue {

struct NumberedRow {
    std::uint64_t number = 0;  // order of addition since the daemon's start, from 1
    ResultRow row;
};

/// Thread safety: all functions on any thread; none waits for long.
class ResultsTable {
public:
    static constexpr std::size_t most_rows = 1000;

    /// Adds rows. Beyond most_rows, the earliest by time are dropped.
    void add(const std::vector<ResultRow>& rows);
    /// Rows with a number above `seen`, in order of time.
    [[nodiscard]] std::vector<NumberedRow> since(std::uint64_t seen) const;
    /// Number of the row that was added last; 0: none.
    [[nodiscard]] std::uint64_t newest() const;

private:
    mutable std::mutex mutex_;
    std::vector<NumberedRow> rows_;  // in order of time
    std::uint64_t numbers_ = 0;
};

}  // namespace shaker::catalogue
