#pragma once
// Where the walker will go: its drift velocity predicted before the drive starts.
#include <optional>
#include <string>
#include <vector>

#include "daemon/reduction/series.hpp"
#include "daemon/run/walker_monitor.hpp"
#include "drivers/drive.hpp"

namespace shaker::run {

struct PredictedWalk {
    calibration::Estimate v_D;  // m/s
    std::string from;           // its source, for the operator
};

/// Error of any predicted walk, m/s, beyond that of the point or of mu: 5 % of the base's rms velocity, for
/// tilt, overtones and mu that depends on speed.
double unknown_error(const Drive& drive);

/// By the newest measured point with this drive or with its mirror image (phi + pi, opposite drift); empty
/// without one. The error as at predict_walk().
std::optional<PredictedWalk> measured_walk(const Drive& drive,
                                           const std::vector<reduction::DrivenPoint>& points);

/// As measured; without such a point by the exact Coulomb law, if mu is known (finite). Empty without either.
/// The error contains the uncertainty of the point or of mu, and unknown_error(). g in m/s^2.
std::optional<PredictedWalk> predict_walk(const Drive& drive,
                                          const std::vector<reduction::DrivenPoint>& points,
                                          const calibration::Estimate& mu, double g);

/// The weakest walk of this drive, by the exact Coulomb law, for any friction coefficient from 0.05 to 0.2;
/// the error as at predict_walk(). Empty when its direction depends on the friction. g in m/s^2.
std::optional<PredictedWalk> walk_at_usual_friction(const Drive& drive, double g);

/// "predicted walk +12.3 +- 0.4 mm/s (source)".
std::string text(const PredictedWalk& walk);
/// The walk, and how long the walker stays inside the edge limit: "...: about 119 periods until the edge
/// limit". Empty before the walker was found, and for a walk that leads nowhere. edge_mm: of the limits.
std::string what_fits(const PredictedWalk& walk, const WalkerMonitor& walker, double edge_mm,
                      const Drive& drive);
/// True if the walk leads towards `direction` (+1 or -1 along x) by more than three times its error.
bool leads_towards(const PredictedWalk& walk, int direction) noexcept;

}  // namespace shaker::run
