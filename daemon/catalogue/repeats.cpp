#include "daemon/catalogue/repeats.hpp"

#include <algorithm>

#include "daemon/reduction/series.hpp"

namespace shaker::catalogue {
namespace {

/// `rows`: in order of time, as the passes of a point, so that equal ones give equal bits.
Repeats combine(const std::vector<const ResultRow*>& rows) {
    const auto of_each = [&](calibration::Estimate ResultRow::*member) {
        std::vector<calibration::Estimate> all;
        for (const ResultRow* row : rows) all.push_back(row->*member);
        return all;
    };
    std::vector<reduction::PassDrift> passes;
    double squares = 0, mean = 0, scatter = 0;
    const auto n = static_cast<double>(rows.size());
    for (const ResultRow* row : rows) {
        passes.push_back({row->v_D, static_cast<int>(row->periods)});
        squares += row->v_D.sigma * row->v_D.sigma / n;
        mean += row->v_D.value / n;
    }
    for (const ResultRow* row : rows) scatter += std::pow(row->v_D.value - mean, 2) / (n - 1);
    const reduction::CombinedDrift drift = reduction::combined(passes);
    return {.asked = *rows.front()->asked,
            .newest = rows.back()->time,
            .count = static_cast<int>(rows.size()),
            .v_D = drift.v_D,
            .D = reduction::weighted(of_each(&ResultRow::D), drift.weights),
            .efficiency = reduction::weighted(of_each(&ResultRow::efficiency), drift.weights),
            .stated = std::sqrt(squares),
            .scatter = rows.size() > 1 ? std::sqrt(scatter) : NAN};
}

}  // namespace

std::vector<Repeats> repeats_of(std::span<const NumberedRow> rows) {
    std::vector<std::vector<const ResultRow*>> groups;
    for (std::size_t i = rows.size(); i-- > 0;) {
        const ResultRow& row = rows[i].row;
        if (!row.asked || !row.steady || !std::isfinite(row.v_D.value) || !std::isfinite(row.v_D.sigma) ||
            !std::isfinite(row.periods))
            continue;
        const auto found =
            std::ranges::find_if(groups, [&](const auto& g) { return *g.front()->asked == *row.asked; });
        (found == groups.end() ? groups.emplace_back() : *found).push_back(&row);
    }
    std::vector<Repeats> all;
    for (auto& group : groups) {
        std::ranges::reverse(group);
        all.push_back(combine(group));
    }
    return all;
}

}  // namespace shaker::catalogue
