#include "calibration/camera/board_corners.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "calibration/camera/corner_fit.hpp"
#include "drivers/codecs/codecs.hpp"

namespace shaker::calibration {

namespace {

using optics::Board;
using Corners =
    std::array<std::array<double, 2>, 4>;  // of a marker: top left, top right, bottom right, bottom left

std::map<int, Corners> markers_in(const GreyPicture& picture) {
    std::vector<unsigned char> grey(picture.grey.size());
    std::ranges::transform(picture.grey, grey.begin(), [](float g) {
        return static_cast<unsigned char>(std::clamp(std::lround(g), 0L, 255L));
    });
    std::map<int, Corners> found;
    for (const codecs::Marker& m : codecs::find_markers(grey, picture.width, picture.height))
        found[m.number] = m.corners_px;
    return found;
}

// What a marker says of the corner of its square towards (right, down): where it is, and the board's axes.
ExpectedCorner by_marker(const Board& board, const Corners& c, bool right, bool down) {
    const std::size_t near = down ? (right ? 2 : 3) : (right ? 1 : 0);
    const double margin = 0.5 * (board.square_mm - board.marker_mm) / board.marker_mm;
    const double scale = board.square_mm / board.marker_mm;
    ExpectedCorner e;
    for (std::size_t k = 0; k < 2; ++k) {
        const double x = 0.5 * (c[1][k] - c[0][k] + c[2][k] - c[3][k]);
        const double y = 0.5 * (c[3][k] - c[0][k] + c[2][k] - c[1][k]);
        e.at_px[k] = c[near][k] + margin * ((right ? x : -x) + (down ? y : -y));
        e.x_px[k] = scale * x;
        e.y_px[k] = scale * y;
    }
    e.quiet_share = margin / scale;
    return e;
}

// The mean of what the markers of the two light squares at a corner say; false when neither was found.
bool expect(const Board& board, const std::map<int, Corners>& markers, int number, ExpectedCorner& out) {
    const int x = number % (board.columns - 1), y = number / (board.columns - 1);
    int count = 0;
    for (const bool left : {true, false})
        for (const bool above : {true, false}) {
            const int column = left ? x : x + 1, row = above ? y : y + 1;
            if ((column + row) % 2 == 0) continue;  // dark
            const auto marker = markers.find(board.marker_of(column, row));
            if (marker == markers.end()) continue;
            const ExpectedCorner e = by_marker(board, marker->second, left, above);
            ++count;
            for (std::size_t k = 0; k < 2; ++k) {
                out.at_px[k] += (e.at_px[k] - out.at_px[k]) / count;
                out.x_px[k] += (e.x_px[k] - out.x_px[k]) / count;
                out.y_px[k] += (e.y_px[k] - out.y_px[k]) / count;
            }
            out.quiet_share = e.quiet_share;
        }
    return count > 0;
}

}  // namespace

SeenBoard find_board(const GreyPicture& picture, const Board& board, std::string name) {
    SeenBoard seen{.name = std::move(name), .width = picture.width, .height = picture.height};
    std::map<int, Corners> markers = markers_in(picture);
    std::erase_if(markers, [&](const auto& m) { return m.first >= board.columns * board.rows / 2; });
    seen.markers = static_cast<int>(markers.size());
    std::vector<double> blurs;
    for (int number = 0; number < board.corners(); ++number) {
        ExpectedCorner expected;
        if (!expect(board, markers, number, expected)) continue;
        const auto corner = fit_corner(picture, expected);
        if (!corner) continue;
        seen.corners.push_back({number, corner->at_px, corner->reach_px});
        blurs.push_back(corner->blur);
    }
    if (!blurs.empty()) {
        const auto middle = blurs.begin() + static_cast<std::ptrdiff_t>(blurs.size() / 2);
        std::ranges::nth_element(blurs, middle);
        seen.blur = *middle;
    }
    return seen;
}

}  // namespace shaker::calibration
