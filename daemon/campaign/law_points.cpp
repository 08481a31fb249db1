#include "daemon/campaign/law_points.hpp"

#include <cmath>
#include <map>

namespace shaker::campaign {

namespace {

constexpr double views = 2;  // at most; the number of cameras is not in the table

law::Point with_numbers(const PointRow& row, int campaign) {
    law::Point p;
    p.number = row.point;
    p.campaign = campaign;
    p.partner = row.partner;
    p.series = row.series;
    p.asked = row.asked;
    p.frequency = row.frequency.value;
    p.gamma = row.gamma;
    p.rho = row.rho;
    p.phi = row.phi;
    p.v_D = row.v_D;
    p.true_v_D = row.true_v_D;
    p.periods = static_cast<int>(std::lround(row.periods));
    if (row.periods > 0) p.phases_per_period = row.frames / row.periods / views;
    return p;
}

}  // namespace

std::vector<law::Point> law_points(const PointsTable& table, int campaign) {
    std::map<int, law::Point> found;
    for (const PointRow& row : table.points) {
        const bool measured = row.outcome == "measured" && std::isfinite(row.v_D.value) &&
                              row.v_D.sigma > 0 && std::isfinite(row.frequency.value) &&
                              row.frequency.value > 0;
        if (measured) found.emplace(row.point, with_numbers(row, campaign));
    }
    const auto point = [&](int number) {
        const auto at = found.find(number);
        return at == found.end() ? nullptr : &at->second;
    };
    for (const PointHarmonic& h : table.harmonics) {
        law::Point* p = point(h.point);
        const double amplitude = h.measured.amplitude.value, sd = h.measured.amplitude.sigma;
        if (p == nullptr || h.measured.q < 1 || h.measured.q > max_harmonics || !std::isfinite(amplitude))
            continue;
        const double phase = std::isfinite(h.measured.phase.value) ? h.measured.phase.value : 0;
        p->base.at(h.measured.q) = std::polar(amplitude, phase);
        p->base_sd[static_cast<std::size_t>(h.measured.q - 1)] = std::isfinite(sd) ? sd : 0;
        if (h.measured.q > 2 && h.measured.q <= most_driven)
            p->asked.overtones[static_cast<std::size_t>(h.measured.q - 3)] =
                std::polar(h.asked / p->asked.gamma, h.asked_phase);
    }
    for (const PointPhase& c : table.cycle) {
        law::Point* p = point(c.point);
        if (p == nullptr || !std::isfinite(c.v_mps)) continue;
        p->cycle.phase.push_back(c.phase);
        p->cycle.x_m.push_back(c.x_m);
        p->cycle.x_sd_m.push_back(c.x_sd_m);
        p->cycle.v_mps.push_back(c.v_mps);
        p->cycle.v_sd_mps.push_back(c.v_sd_mps);
        p->cycle.v_base_mps.push_back(c.v_base_mps);
    }
    for (const PointStick& s : table.stick)
        if (law::Point* p = point(s.point)) p->stick.push_back(s.interval);
    std::vector<law::Point> out;
    for (auto& [number, p] : found)
        if (p.base.order() > 0) out.push_back(std::move(p));
    return out;
}

}  // namespace shaker::campaign
