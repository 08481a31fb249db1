#include "daemon/campaign/lead/event_text.hpp"

#include <spdlog/fmt/fmt.h>

#include <numbers>

namespace shaker::campaign {

std::string place(const Point& p) {
    return fmt::format("{} {:.4g} Hz gamma {:.4g} m/s^2 rho {:.3g} phi {:.1f} deg", p.series,
                       p.asked.drive.frequency, p.asked.drive.gamma, p.asked.drive.rho,
                       p.asked.drive.phi * 180 / std::numbers::pi);
}

std::string text(const Event& event, const Engine& engine, const std::vector<Point>& points) {
    if (const auto* ended = std::get_if<PointEnded>(&event)) {
        const calibration::Estimate v_D = engine.result(ended->point);
        const std::string result =
            ended->outcome == Outcome::measured
                ? fmt::format("v_D {:+.4f} +- {:.4f} mm/s", 1e3 * v_D.value, 1e3 * v_D.sigma)
                : fmt::format("{}: {}", outcome_words[static_cast<std::size_t>(ended->outcome)],
                              ended->reason);
        return fmt::format("point {} of {}  {}  {}", ended->point, points.size(),
                           place(points.at(static_cast<std::size_t>(ended->point - 1))), result);
    }
    if (const auto* change = std::get_if<CampaignChange>(&event))
        return fmt::format("{}: {}", CampaignChange::words[static_cast<std::size_t>(change->what)],
                           change->reason);
    if (const auto* lost = std::get_if<PassLost>(&event))
        return fmt::format("point {}, pass {} does not count: {}", lost->point, lost->pass, lost->reason);
    return {};
}

}  // namespace shaker::campaign
