#include "drivers/footage/grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace shaker::footage {

double usual_step(const std::vector<double>& t_s) {
    std::vector<double> steps(t_s.size() - 1);
    for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = t_s[i + 1] - t_s[i];
    std::vector<double> sorted = steps;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    double sum = 0, count = 0;
    for (const double step : steps)
        if (step > 0.5 * *middle && step < 1.5 * *middle) sum += step, ++count;
    return sum / count;
}

Grid fitted_grid(const std::vector<double>& t_s, double step_s) {
    constexpr double follows = 0.1;  // share of a stamp's deviation by which the running line moves
    Grid grid;
    double line_s = t_s.front();
    for (const double t : t_s) {
        const double steps =
            grid.ticks.empty() ? 0 : std::clamp(std::round((t - line_s) / step_s), 1.0, 1e15);
        grid.ticks.push_back((grid.ticks.empty() ? 0 : grid.ticks.back()) + static_cast<std::int64_t>(steps));
        const double expected_s = line_s + steps * step_s;
        line_s = expected_s + follows * (t - expected_s);
    }
    double mean_n = 0, mean_t = 0;
    const auto count = static_cast<double>(t_s.size());
    for (std::size_t i = 0; i < t_s.size(); ++i) {
        mean_n += static_cast<double>(grid.ticks[i]) / count;
        mean_t += (t_s[i] - t_s.front()) / count;
    }
    double nn = 0, nt = 0;
    for (std::size_t i = 0; i < t_s.size(); ++i) {
        const double n = static_cast<double>(grid.ticks[i]) - mean_n;
        nn += n * n;
        nt += n * ((t_s[i] - t_s.front()) - mean_t);
    }
    grid.step_s = nt / nn;
    grid.first_s = t_s.front() + (mean_t - grid.step_s * mean_n);
    for (std::size_t i = 0; i < t_s.size(); ++i)
        grid.off_s = std::max(
            grid.off_s, std::abs(t_s[i] - grid.first_s - grid.step_s * static_cast<double>(grid.ticks[i])));
    return grid;
}

}  // namespace shaker::footage
