#include "calibration/harmonics/harmonic_sums.hpp"

#include <cmath>

#include "calibration/harmonics/harmonic_model.hpp"
#include "drivers/drive.hpp"

namespace shaker::calibration {
namespace {

/// Moves amplitudes and their covariance to another origin of time.
void move_origin(HarmonicFit& fit, double to_s) {
    const double late = to_s - fit.origin_s;
    if (late == 0) return;
    const auto n = 2 * static_cast<Eigen::Index>(fit.order());
    Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(n, n);
    for (int q = 1; q <= fit.order(); ++q) {
        const std::complex<double> z =
            std::polar(1.0, two_pi * std::remainder(q * fit.frequency_hz * late, 1.0));
        fit.a[static_cast<std::size_t>(q - 1)] *= z;
        const Eigen::Index i = 2 * (static_cast<Eigen::Index>(q) - 1);
        turn.block<2, 2>(i, i) << z.real(), -z.imag(), z.imag(), z.real();
    }
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> covariance(fit.covariance.data(), n, n);
    covariance = (turn * covariance * turn.transpose()).eval();
    for (double& c : fit.constants) c += fit.slope.value * late;
    fit.origin_s = to_s;
}

}  // namespace

HarmonicSums::HarmonicSums(std::span<const HarmonicSamples> streams, double frequency_hz, int order,
                           Slope slope)
    : frequency_hz_(frequency_hz), order_(order), slope_(slope) {
    const HarmonicModel m = model_of(streams, frequency_hz, order, slope);
    origin_s_ = m.origin_s;
    half_span_s_ = m.half_span_s;
    for (const HarmonicSamples& s : streams) {
        const auto [weight, weighted_t] = time_weight(s);
        const NormalEquations sums = normal_equations(m, s.t, s.sd, {&s.y, 1});
        streams_.push_back({s,
                            weight,
                            weighted_t,
                            {sums.normal.reshaped().begin(), sums.normal.reshaped().end()},
                            {sums.right.reshaped().begin(), sums.right.reshaped().end()}});
    }
}

HarmonicSums HarmonicSums::of_stream(std::size_t k) const {
    HarmonicSums one = *this;
    one.streams_ = {streams_.at(k)};
    return one;
}

HarmonicFit HarmonicSums::fit(int order, std::span<const double> scale) const {
    HarmonicModel m{.frequency_hz = frequency_hz_,
                    .origin_s = origin_s_,
                    .half_span_s = half_span_s_,
                    .order = order,
                    .slope = slope_};
    const int shared = m.constant_column(), n = shared + static_cast<int>(streams_.size());
    const int gathered = 2 * order_ + (shared - 2 * order) + 1;
    std::vector<int> from(static_cast<std::size_t>(shared) + 1), to(from.size());
    for (int i = 0; i < shared; ++i) {
        to[static_cast<std::size_t>(i)] = i;
        from[static_cast<std::size_t>(i)] = i < 2 * order ? i : 2 * order_;
    }
    from.back() = gathered - 1;
    NormalEquations sums{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, 1)};
    HarmonicFit out;
    double weight = 0, weighted_t = 0;
    for (std::size_t k = 0; k < streams_.size(); ++k) {
        const Stream& s = streams_[k];
        const double w = scale.empty() ? 1.0 : 1 / (scale[k] * scale[k]);
        to.back() = shared + static_cast<int>(k);
        const Eigen::Map<const Eigen::MatrixXd> normal(s.normal.data(), gathered, gathered);
        const Eigen::Map<const Eigen::VectorXd> right(s.right.data(), gathered);
        sums.normal(to, to) += w * normal(from, from);
        sums.right(to, 0) += w * right(from);
        out.samples += s.samples.t.size();
        weight += w * s.weight;
        weighted_t += w * s.weighted_t;
    }
    const Solution solved = solve(m, sums, out.samples);
    double chi2 = 0, squares = 0;
    for (std::size_t k = 0; k < streams_.size(); ++k) {
        const HarmonicSamples& s = streams_[k].samples;
        to.back() = shared + static_cast<int>(k);
        const Remainder left = remainders(m, s.t, s.sd, {&s.y, 1}, solved.p(to, Eigen::all)).front();
        chi2 += scale.empty() ? left.chi2 : left.chi2 / (scale[k] * scale[k]);
        squares += left.squares;
        out.stream_rms.push_back(std::sqrt(left.chi2 / static_cast<double>(s.t.size())));
    }
    set_solution(out, m, solved, 0, {chi2, squares});
    move_origin(out, weight > 0 ? weighted_t / weight : 0.0);
    return out;
}

}  // namespace shaker::calibration
