#include "daemon/reduction/across_measured.hpp"

#include <array>
#include <cmath>

namespace shaker {

void measure_across(const Alignment& drive, const AccelSeries& samples,
                    std::vector<MeasuredHarmonic>& harmonics) {
    const auto axes = across_axes(drive.shaker_axis);
    std::array<HarmonicFit, 2> fits;
    for (std::size_t k = 0; k < 2; ++k) {
        std::vector<double> y;
        y.reserve(drive.t_s.size());
        for (std::size_t i = 0; i < drive.t_s.size(); ++i) {
            const auto& a = samples.a_mps2[drive.first_sample + i];
            y.push_back(a[0] * axes[k][0] + a[1] * axes[k][1] + a[2] * axes[k][2]);
        }
        const HarmonicSamples stream{drive.t_s, y, {}};
        fits[k] = fit_harmonics({&stream, 1}, drive.frequency.value, drive.acceleration.order(), Slope::none);
    }
    for (MeasuredHarmonic& h : harmonics) {
        double variance = 0;
        for (const HarmonicFit& fit : fits)
            for (const int i : {2 * (h.q - 1), 2 * (h.q - 1) + 1}) variance += fit.cov(i, i) / 4;
        h.across = transverse(drive.acceleration.at(h.q), {fits[0].at(h.q), fits[1].at(h.q)},
                              drive.shaker_axis, std::sqrt(variance));
    }
}

}  // namespace shaker
