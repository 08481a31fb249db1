#include "daemon/remote/web/picture_figures.hpp"

#include <algorithm>
#include <vector>

#include "tracking/clipping.hpp"
#include "tracking/image/pixels.hpp"

namespace shaker::web {

namespace {

constexpr int most_rows = 32;
constexpr double least_contrast = 0.05;  // of an edge, as a share of the picture's largest value

struct Edge {
    double slope = 0, width_px = 0;
};

// The steepest edge of a row: as far as the values rise or fall without a turn.
template <class T>
Edge steepest(const T* row, int n, double least) {
    const auto slope_at = [&](int x) {
        return 0.5 * (static_cast<double>(row[x + 1]) - static_cast<double>(row[x - 1]));
    };
    int at = 1;
    for (int x = 2; x + 1 < n; ++x)
        if (std::abs(slope_at(x)) > std::abs(slope_at(at))) at = x;
    const double slope = std::abs(slope_at(at));
    const bool rises = slope_at(at) > 0;
    int from = at - 1, to = at + 1;
    while (from > 0 && (rises ? row[from - 1] < row[from] : row[from - 1] > row[from])) --from;
    while (to + 1 < n && (rises ? row[to + 1] > row[to] : row[to + 1] < row[to])) ++to;
    const double height = std::abs(static_cast<double>(row[to]) - static_cast<double>(row[from]));
    return height < least || slope <= 0 ? Edge{} : Edge{slope, height / slope};
}

double edge_width_px(const ImageView& image) {
    return tracking::with_pixels(image, [&](auto pixels) {
        const int step = (image.height + most_rows - 1) / most_rows;
        double largest = 0, slope = 0;
        for (int y = 0; y < image.height; y += step)
            largest = std::max(
                largest, static_cast<double>(*std::max_element(pixels.row(y), pixels.row(y) + image.width)));
        std::vector<Edge> edges;
        for (int y = 0; y < image.height; y += step) {
            edges.push_back(steepest(pixels.row(y), image.width, least_contrast * largest));
            slope = std::max(slope, edges.back().slope);
        }
        std::erase_if(edges, [&](const Edge& e) { return e.slope <= 0 || e.slope < slope / 2; });
        if (edges.empty()) return double{NAN};
        const auto middle = edges.begin() + static_cast<std::ptrdiff_t>(edges.size() / 2);
        std::nth_element(edges.begin(), middle, edges.end(),
                         [](const Edge& a, const Edge& b) { return a.width_px < b.width_px; });
        return middle->width_px;
    });
}

}  // namespace

PictureFigures figures_of(const Frame& frame) {
    if (frame.pixels.empty() || frame.width < 3) return {};
    const ImageView image = frame.view();
    return {tracking::clipped_share(image, tracking::whole(image)), edge_width_px(image)};
}

}  // namespace shaker::web
