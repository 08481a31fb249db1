#include "daemon/law/point.hpp"

namespace shaker::law {

Point point_of(const reduction::Reduction& result, const Drive& asked) {
    Point p;
    p.asked = asked;
    p.frequency = result.frequency.value;
    p.gamma = result.gamma;
    p.rho = result.rho;
    p.phi = result.phi;
    p.v_D = result.v_D;
    p.periods = static_cast<int>(result.periods.size());
    for (const reduction::MeasuredHarmonic& h : result.harmonics) {
        if (h.q < 1 || h.q > max_harmonics || !std::isfinite(h.amplitude.value)) continue;
        const double phase = std::isfinite(h.phase.value) ? h.phase.value : 0;
        p.base.at(h.q) = std::polar(h.amplitude.value, phase);
        p.base_sd[static_cast<std::size_t>(h.q - 1)] =
            std::isfinite(h.amplitude.sigma) ? h.amplitude.sigma : 0;
    }
    return p;
}

}  // namespace shaker::law
