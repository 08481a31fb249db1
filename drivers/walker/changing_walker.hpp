#pragma once
// ChangingWalker: a walker under any law of friction whose mu changes from period to period.
#include <optional>

#include "drivers/walker/friction.hpp"
#include "drivers/walker/integrated_walker.hpp"

namespace shaker::walker {

/// mu is constant within a period, so where slip has a closed form each period is exact: it is a Walker on
/// the law of that period. Other laws are integrated.
class ChangingWalker {
public:
    /// Starts at phase 0 with velocity v (m/s). Throws InputError as checked() does.
    explicit ChangingWalker(const WalkerSetting& setting, double v = 0);
    ChangingWalker(const ChangingWalker&) = delete;
    ChangingWalker& operator=(const ChangingWalker&) = delete;

    /// Advances to the next start of a period. Returns D, m.
    double advance_period();
    [[nodiscard]] WalkerPoint now() const noexcept { return now_; }
    /// Factor of mu_k and mu_s in the last period.
    [[nodiscard]] double mu_factor() const noexcept { return mu_factor_; }
    /// Number of completed periods.
    [[nodiscard]] std::int64_t period() const noexcept { return period_; }

private:
    [[nodiscard]] WalkerLaw law_with(double mu_factor) const;

    WalkerSetting setting_;
    MuHistory history_;
    double mu_factor_ = 1;
    std::optional<IntegratedWalker> integrated_;  // law without a closed form
    std::optional<WalkerLaw> law_;                // of the last period
    WalkerPoint now_;
    std::int64_t period_ = 0;
};

/// Mean walk over many periods.
struct MeanWalk {
    double v_D = 0;        // m/s
    double v_D_error = 0;  // standard error from the scatter of 16 batches, m/s
    double mu_factor = 1;  // mean
};

/// Walks `skipped` periods, then averages over `periods`, at least 16.
MeanWalk mean_walk(const WalkerSetting& setting, double v_start, int skipped, int periods);

}  // namespace shaker::walker
