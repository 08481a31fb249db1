#include "tests/support/tracking/building_swing.hpp"

#include <array>

namespace shaker::test {

View beam_view(const std::string& beam) {
    using Dots = std::array<std::array<int, 2>, 7>;  // px
    constexpr Dots top{{{110, 58}, {266, 55}, {426, 50}, {585, 48}, {739, 46}, {897, 46}, {1061, 43}}};
    constexpr Dots bottom{{{154, 46}, {314, 41}, {478, 40}, {639, 39}, {801, 40}, {963, 40}, {1132, 43}}};
    View view;
    view.camera = beam;
    view.mm_per_px = 1;  // unknown
    for (const auto& [x, y] : beam == "top" ? top : bottom) {
        Target dot{"dot" + std::to_string(view.targets.size() + 1), TargetKind::dots};
        dot.diameter_mm = 20;
        dot.roi_px = {x - 20, y - 20, 40, 40};
        dot.polarity = Polarity::dark;
        view.targets.push_back(dot);
    }
    return view;
}

std::vector<std::vector<tracking::Fix>> follow(const View& view, const std::vector<Shot>& movie) {
    tracking::ViewTracker tracker{view};
    std::vector<std::vector<tracking::Fix>> all;
    for (const Shot& shot : movie) {
        const auto fixes = tracker.update(shot.view(), CameraTick{static_cast<std::int64_t>(all.size())});
        all.emplace_back(fixes.begin(), fixes.end());
    }
    return all;
}

}  // namespace shaker::test
