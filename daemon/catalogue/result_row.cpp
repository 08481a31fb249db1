#include "daemon/catalogue/result_row.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

namespace shaker::catalogue {

namespace {

std::string end_of(const ResultRow& row, int periods) {
    if (periods == 0 || row.periods >= periods) return "complete";
    return fmt::format("ended after {:.0f} of {} periods", row.periods, periods);
}

}  // namespace

ResultRow row_of(const recording::FinishedMeasurement& finished, const reduction::Reduction* reduction,
                 const std::string& not_reduced, int periods) {
    ResultRow row;
    row.asked = finished.asked;
    row.periods = std::round((finished.part.to_s - finished.part.from_s) * finished.asked.frequency);
    row.ended = reduction != nullptr ? end_of(row, periods) : "no result: " + not_reduced;
    if (reduction == nullptr) return row;
    const reduction::Reduction& r = *reduction;
    row.gamma = r.gamma;
    row.rho = r.rho;
    row.phi = r.phi;
    row.v_D = r.v_D;
    row.D = r.D;
    row.efficiency = r.efficiency;
    row.ratio = r.gain_ratio.ratio;
    row.steady = !std::isfinite(r.v_D_settled.value) && !r.degraded;
    row.notes = fmt::format("{}", fmt::join(r.notes, "; "));
    return row;
}

ResultRow interrupted_row(const std::optional<Drive>& asked, const std::string& why) {
    ResultRow row;
    row.asked = asked;
    row.ended = why;
    return row;
}

}  // namespace shaker::catalogue
