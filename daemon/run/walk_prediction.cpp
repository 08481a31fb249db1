#include "daemon/run/walk_prediction.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ranges>

#include "daemon/safety/preflight.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/no_stick.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::run {

namespace {

constexpr double sure = 3;  // errors

// The same drive, or its mirror image: every odd harmonic has the opposite sign, or the second one.
bool alike(const Drive& a, const Drive& b, double phi) {
    return a.frequency == b.frequency && a.gamma == b.gamma && a.rho == b.rho && a.biharmonic() &&
           b.biharmonic() && std::abs(std::remainder(a.phi - b.phi - phi, two_pi)) < 1e-6;
}

double settled_drift(const Drive& drive, double mu, double g) {
    return settle(walker::WalkerLaw{walker::coulomb(drive, mu, g)}).v_D;
}

}  // namespace

double unknown_error(const Drive& drive) {
    constexpr double share = 0.05;
    return share * walker::v_rms(harmonics(drive), drive.frequency);
}

std::optional<PredictedWalk> measured_walk(const Drive& drive,
                                           const std::vector<reduction::DrivenPoint>& points) {
    for (const reduction::DrivenPoint& p : points | std::views::reverse)
        for (const bool mirror : {false, true})
            if (alike(drive, p.asked, mirror ? std::numbers::pi : 0))
                return PredictedWalk{
                    {mirror ? -p.v_D.value : p.v_D.value, std::hypot(p.v_D.sigma, unknown_error(drive))},
                    mirror ? "measured at phi + 180 deg" : "measured before at this set-point"};
    return std::nullopt;
}

std::optional<PredictedWalk> predict_walk(const Drive& drive,
                                          const std::vector<reduction::DrivenPoint>& points,
                                          const calibration::Estimate& mu, double g) {
    if (auto measured = measured_walk(drive, points)) return measured;
    if (!std::isfinite(mu.value)) return std::nullopt;
    try {
        const double v_D = settled_drift(drive, mu.value, g);
        const double step = std::max(mu.sigma, 1e-3 * mu.value);
        const double slope = (settled_drift(drive, mu.value + step, g) - v_D) / step;
        return PredictedWalk{{v_D, std::hypot(slope * mu.sigma, unknown_error(drive))},
                             fmt::format("Coulomb's law with mu {:.4g}", mu.value)};
    } catch (const InputError&) {
        return std::nullopt;  // no settled walk
    }
}

std::optional<PredictedWalk> walk_at_usual_friction(const Drive& drive, double g) {
    PredictedWalk weakest{{INFINITY, unknown_error(drive)}, "Coulomb's law with any mu from 0.05 to 0.2"};
    try {
        double sum = 0, sizes = 0;
        for (const double mu : {0.05, 0.1, 0.15, 0.2}) {
            const double v_D = settled_drift(drive, mu, g);
            if (std::abs(v_D) < std::abs(weakest.v_D.value)) weakest.v_D.value = v_D;
            sum += v_D;
            sizes += std::abs(v_D);
        }
        if (std::abs(sum) < sizes) return std::nullopt;
    } catch (const InputError&) {
        return std::nullopt;  // no settled walk
    }
    return weakest;
}

std::string text(const PredictedWalk& walk) {
    return fmt::format("predicted walk {:+.3g} +- {:.2g} mm/s ({})", 1e3 * walk.v_D.value,
                       1e3 * walk.v_D.sigma, walk.from);
}

std::string what_fits(const PredictedWalk& walk, const WalkerMonitor& walker, double edge_mm,
                      const Drive& drive) {
    const double periods = periods_to_edge(walker.ways_m(edge_mm), walk.v_D.value / drive.frequency,
                                           safety::largest_displacement(harmonics(drive), drive.frequency));
    if (!std::isfinite(periods)) return {};
    return fmt::format("{}: about {:.0f} periods until the edge limit", text(walk), std::floor(periods));
}

bool leads_towards(const PredictedWalk& walk, int direction) noexcept {
    return direction * walk.v_D.value > sure * walk.v_D.sigma;
}

}  // namespace shaker::run
