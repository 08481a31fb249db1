#pragma once
// A measurement as a row of the table of results, and the newest rows of a bench: those of the present
// daemon, and those of its recordings of before.
#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/reduction/quantities.hpp"
#include "drivers/drive.hpp"

namespace shaker::catalogue {

/// A measurement of the present daemon, or read back from a recording.
struct ResultRow {
    std::string time;                       // of its end, UTC: "2026-11-26T19:43:32Z"; empty: not known
    std::optional<Drive> asked;             // set-point; empty: not known
    double periods = NAN;                   // whole periods of the drive
    calibration::Estimate gamma, rho, phi;  // measured, m/s^2, 1, rad; NaN: no result
    calibration::Estimate v_D, D;           // m/s, m per period
    calibration::Estimate efficiency;       // |v_D| / V_RMS
    calibration::Estimate ratio;            // bench check: cameras over accelerometer
    bool steady = false;                    // the walker had settled, and the result is not degraded
    std::string notes;                      // on the result, with the reason when it is not steady
    std::string ended;                      // "complete", or why it is shorter or has no result
    std::string recording;                  // file name; empty: not recorded
};

/// A quantity in the table of results.
struct ListedQuantity {
    const reduction::Quantity& quantity;
    calibration::Estimate ResultRow::*member;
};
/// In the order of the columns.
inline constexpr std::array listed_quantities{
    ListedQuantity{reduction::quantity("gamma"), &ResultRow::gamma},
    ListedQuantity{reduction::quantity("rho"), &ResultRow::rho},
    ListedQuantity{reduction::quantity("phi"), &ResultRow::phi},
    ListedQuantity{reduction::quantity("v_D"), &ResultRow::v_D},
    ListedQuantity{reduction::quantity("D"), &ResultRow::D},
    ListedQuantity{reduction::quantity("efficiency"), &ResultRow::efficiency},
    ListedQuantity{reduction::quantity("bench_check"), &ResultRow::ratio}};

/// The row of a finished measurement. reduction: null with the reason in not_reduced. periods: that were
/// asked for; 0: not known. Time and recording stay empty.
ResultRow row_of(const recording::FinishedMeasurement& finished, const reduction::Reduction* reduction,
                 const std::string& not_reduced, int periods);
/// The row of a measurement that a stop interrupted.
ResultRow interrupted_row(const std::optional<Drive>& asked, const std::string& why);

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
