#include "daemon/campaign/common_errors.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>

#include "daemon/reduction/spread/common_scatter.hpp"
#include "daemon/reduction/spread/drift_spread.hpp"
#include "drivers/drive.hpp"

namespace shaker::campaign {

namespace {

using calibration::Estimate;
using reduction::Reduction;
using reduction::WalkerRecord;

// m; the amplitude is that of the mean period.
double response_of(const Reduction& r) {
    std::complex<double> sum;
    for (std::size_t i = 0; i < r.cycle.phase.size(); ++i)
        sum += (r.cycle.x_m[i] - r.D.value * r.cycle.phase[i]) * std::polar(1.0, -two_pi * r.cycle.phase[i]);
    return reduction::response_to_friction * 2 * std::abs(sum) / static_cast<double>(r.cycle.phase.size());
}

// The longest part without a gap.
std::vector<reduction::PeriodMean> means_of(const Reduction& r) {
    std::vector<reduction::PeriodMean> longest, now;
    for (const reduction::PeriodResult& p : r.periods) {
        const bool follows = std::isfinite(p.drift.value) && !now.empty() && now.back().k + 1 == p.k;
        if (!follows) now.clear();
        if (p.frames > 0) now.push_back({p.k, follows ? now.back().y_m + p.drift.value : 0, p.frames});
        if (now.size() > longest.size()) longest = now;
    }
    return longest;
}

WalkerRecord record_of(const Reduction& r, int periods) {
    WalkerRecord record{.means = means_of(r), .periods = periods};
    double frames = 0;
    for (const reduction::PeriodMean& m : record.means) frames += m.frames;
    record.white_m = r.fit_residual_x_m.value / std::sqrt(frames / static_cast<double>(record.means.size()));
    record.response_m = response_of(r);
    return record;
}

bool counts(const Reduction& r, const WalkerRecord& record) {
    return record.means.size() >= 3 && record.white_m > 0 && record.response_m > 0 &&
           std::isfinite(r.v_D.sigma) && std::isnan(r.v_D_settled.value);
}

// What the error of a drift (m) has beyond the scatter of its periods. The record's own error by the scatter
// is computed again, without what was seen within periods, which is not stored: most records give it to a
// tenth.
double beyond_scatter(const WalkerRecord& record, double sigma_m) {
    constexpr double known = 1.1;
    const double own =
        reduction::drift_spread(record.means, {.white_m = record.white_m,
                                               .jitter_m = reduction::usual_jitter * record.response_m})
            .sigma_m;
    return sigma_m > known * own ? std::sqrt(sigma_m * sigma_m - own * own) : 0;
}

// Another error of v_D, of which `unit` of the quantity is one m/s.
void exchange(Estimate& of, double was, double is, double unit) {
    of.sigma = std::sqrt(std::max(0.0, of.sigma * of.sigma + unit * unit * (is * is - was * was)));
}

}  // namespace

void state_common_errors(const std::vector<recording::MeasuredResult*>& measured) {
    struct Walker {
        std::vector<Reduction*> measurements;
        std::vector<WalkerRecord> records;
    };
    std::map<double, Walker> at_frequency;
    for (recording::MeasuredResult* m : measured) {
        if (!m->reduction) continue;
        const recording::MeasuredPart& part = m->measurement.part;
        const double f = m->measurement.asked.frequency;
        WalkerRecord record =
            record_of(*m->reduction, static_cast<int>(std::lround((part.to_s - part.from_s) * f)));
        if (!counts(*m->reduction, record)) continue;
        at_frequency[f].measurements.push_back(&*m->reduction);
        at_frequency[f].records.push_back(std::move(record));
    }
    for (auto& [f, walker] : at_frequency) {
        if (walker.records.size() < 2) continue;
        const auto sigmas = common_sigmas(walker.records);
        for (std::size_t i = 0; i < sigmas.size(); ++i) {
            Reduction& r = *walker.measurements[i];
            const double was = r.v_D.sigma;
            r.v_D.sigma = f * std::hypot(sigmas[i], beyond_scatter(walker.records[i], was / f));
            exchange(r.D, was, r.v_D.sigma, 1 / f);
            exchange(r.efficiency, was, r.v_D.sigma, 1 / r.v_rms.value);
        }
    }
}

}  // namespace shaker::campaign
