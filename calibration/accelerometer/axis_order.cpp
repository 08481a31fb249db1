#include "calibration/accelerometer/axis_order.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/errors.hpp"

namespace shaker::calibration {

namespace {

constexpr double clearly_better = 0.5;  // in the sum of cosines of all attitudes
constexpr std::ptrdiff_t fewest_names = 6;

double cosine(const Vector& a, const Vector& b) noexcept { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Sum of the cosines between names and directions in this order.
double agreement(const AxisOrder& order, std::span<const Attitude> attitudes,
                 std::span<const Vector> directions) {
    double sum = 0;
    for (std::size_t i = 0; i < attitudes.size(); ++i)
        if (const auto up = direction_of(attitudes[i].name)) sum += cosine(*up, order(directions[i]));
    return sum;
}

}  // namespace

std::string AxisOrder::sentence() const {
    std::vector<std::string> moved, reversed;
    for (std::size_t i = 0; i < 3; ++i) {
        if (from[i] != i) moved.emplace_back(1, "xyz"[i]);
        if (sign[i] < 0) reversed.emplace_back(1, "xyz"[i]);
    }
    std::string text;
    if (moved.size() == 2) text = fmt::format("axes {} and {} are swapped", moved[0], moved[1]);
    if (moved.size() == 3)
        text = fmt::format("all axes are swapped: x, y, z arrive as {}, {}, {}", "xyz"[from[0]],
                           "xyz"[from[1]], "xyz"[from[2]]);
    if (!reversed.empty())
        text +=
            fmt::format("{}ax{} {} {} flipped", text.empty() ? "" : "; ", reversed.size() == 1 ? "is" : "es",
                        fmt::join(reversed, ", "), reversed.size() == 1 ? "is" : "are");
    if (text.empty()) return text;
    return text + " against the names of the attitudes; the gain matrix corrects it";
}

AxisOrder axis_order(std::span<const Attitude> attitudes, std::span<const Vector> directions) {
    AxisOrder best, order;
    const auto named = std::ranges::count_if(attitudes, [](const Attitude& a) { return !a.name.empty(); });
    double most = agreement(best, attitudes, directions) + clearly_better;
    do {
        for (int signs = 0; signs < 8 && named >= fewest_names; ++signs) {
            for (std::size_t k = 0; k < 3; ++k) order.sign[k] = (signs >> k & 1) != 0 ? -1 : 1;
            const double sum = agreement(order, attitudes, directions);
            if (sum > most) most = sum, best = order;
        }
    } while (std::ranges::next_permutation(order.from).found);
    for (std::size_t i = 0; i < attitudes.size(); ++i) {
        const auto up = direction_of(attitudes[i].name);
        if (!up || cosine(*up, best(directions[i])) > std::cos(same_attitude)) continue;
        throw InputError{fmt::format(
            "{}: the sensor was held {:.0f} deg away from it, near {}; hold it again or correct its name",
            label_of(i, attitudes[i]),
            std::acos(std::clamp(cosine(*up, best(directions[i])), -1.0, 1.0)) * 180 / std::numbers::pi,
            nearest_attitude(best(directions[i])))};
    }
    return best;
}

}  // namespace shaker::calibration
