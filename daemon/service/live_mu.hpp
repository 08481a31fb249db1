#pragma once
// The friction coefficient from the measurements so far, while the bench is used.
#include <future>
#include <vector>

#include "daemon/law/coulomb_fit.hpp"
#include "drivers/beside.hpp"

namespace shaker::service {

/// mu_ac as "shakerd mu" fits it, from the newest measurements. Thread safety: one thread.
class LiveMu {
public:
    /// g in m/s^2. beside: fits are made in a separate thread.
    LiveMu(double g, bool beside) : g_{g}, fitter_{"mu", beside} {}

    /// A measurement at the asked drive.
    void add(const reduction::Reduction& result, const Drive& asked);
    /// Ends and begins fits. True when mu() is new.
    bool follow();
    /// mu_ac of the newest fit; NaN with the reason in its note when it is not known.
    [[nodiscard]] const law::Fit& mu() const noexcept { return mu_; }
    /// The same for predictions of walks: a mu that the measurements refuse is known to 20 %.
    [[nodiscard]] calibration::Estimate to_predict() const noexcept;

private:
    double g_;
    std::vector<law::Point> points_;
    law::Fit mu_;
    bool newer_ = false;  // points_ are newer than the fit
    std::future<law::CoulombFit> fit_;
    Beside fitter_;
};

}  // namespace shaker::service
