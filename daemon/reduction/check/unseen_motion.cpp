#include "daemon/reduction/check/unseen_motion.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <boost/math/special_functions/sinc.hpp>
#include <cmath>
#include <complex>
#include <numeric>

#include "drivers/drive.hpp"

namespace shaker::reduction {
namespace {

constexpr double visible = 10;    // standard errors of an amplitude by the tracks' own noise
constexpr double smallest = 0.1;  // of the expected amplitude: less is not seen, whatever its error

struct Line {
    double hz = 0, amplitude_m = 0;
};

/// The largest line of a track from lowest_hz to half the frame rate, by its Fourier sum at steps of half the
/// resolution. The first 4096 positions are enough to name a frequency.
Line strongest_line(const calibration::HarmonicSamples& track, double lowest_hz) {
    const std::size_t n = std::min<std::size_t>(track.t.size(), 4096);
    const double mean =
                     std::accumulate(track.y.begin(), track.y.begin() + static_cast<std::ptrdiff_t>(n), 0.0) /
                     static_cast<double>(n),
                 resolution = 1 / (track.t[n - 1] - track.t[0]),
                 highest = 0.5 / calibration::median_step(track.t);
    Line out;
    for (double hz = std::max(lowest_hz, resolution); hz < highest; hz += resolution / 2) {
        std::complex<double> sum = 0;
        for (std::size_t i = 0; i < n; ++i)
            sum += (track.y[i] - mean) * std::polar(1.0, -two_pi * hz * (track.t[i] - track.t[0]));
        const double amplitude = 2 * std::abs(sum) / static_cast<double>(n);
        if (amplitude > out.amplitude_m) out = {hz, amplitude};
    }
    return out;
}

}  // namespace

std::string unseen_motion(const calibration::HarmonicFit& acceleration, std::span<const SeenBase> views) {
    const double f = acceleration.frequency_hz;
    for (const SeenBase& seen : views) {
        const calibration::HarmonicFit& position = seen.position;
        const double track_sd = position.rms / std::max(position.stream_rms.front(), 1e-9),
                     error = track_sd * std::sqrt(2 / static_cast<double>(position.samples));
        for (int q = 1; q <= std::min({position.order(), acceleration.order(), 2}); ++q) {
            const double attenuation = std::abs(boost::math::sinc_pi(two_pi / 2 * q * f * seen.exposure_s)),
                         asked = attenuation * std::abs(acceleration.at(q)) / std::pow(q * two_pi * f, 2),
                         shown = std::abs(position.at(q));
            if (!acceleration.stands_out(q) || asked < visible * error) continue;
            if (position.stands_out(q) && shown > smallest * asked) continue;
            const Line most = strongest_line(seen.track, f / 20);
            return fmt::format(
                "camera \"{}\" does not show the base's motion at {:.4g} Hz: {:.3g} um by the accelerometer, "
                "{:.3g} um by the camera, whose largest motion is {:.3g} um at {:.4g} Hz. "
                "Check frame_rate_hz, the times of the pictures and the base's target; {}",
                seen.view, q * f, 1e6 * asked, 1e6 * shown, 1e6 * most.amplitude_m, most.hz, degraded_note);
        }
    }
    return {};
}

}  // namespace shaker::reduction
