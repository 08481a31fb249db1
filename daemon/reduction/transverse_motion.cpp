#include "daemon/reduction/transverse_motion.hpp"

#include <cmath>

namespace shaker::reduction {

void measure_across(const Alignment& drive, std::vector<MeasuredHarmonic>& harmonics) {
    for (MeasuredHarmonic& h : harmonics) {
        double variance = 0;
        for (const calibration::HarmonicFit& fit : drive.across)
            for (const int i : {2 * (h.q - 1), 2 * (h.q - 1) + 1}) variance += fit.cov(i, i) / 4;
        h.across = calibration::transverse(drive.acceleration.at(h.q),
                                           {drive.across[0].at(h.q), drive.across[1].at(h.q)},
                                           drive.shaker_axis, std::sqrt(variance));
    }
}

}  // namespace shaker::reduction
