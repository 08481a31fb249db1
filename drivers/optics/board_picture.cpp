#include "drivers/optics/board_picture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace shaker::optics {

namespace {

constexpr double reach_sigma = 4.5;

// Edges of the board's cells along one side, from the quiet margin of one square on either side.
std::vector<double> edges_of(const Board& board, int squares) {
    std::vector<double> edges{-board.square_mm};
    for (int square = 0; square < squares; ++square)
        for (int cell = 0; cell < cells_of_square; ++cell)
            edges.push_back(square * board.square_mm + cell_edge(board, cell));
    edges.push_back(squares * board.square_mm);
    edges.push_back((squares + 1) * board.square_mm);
    return edges;
}

// Shares of the cells that a Gaussian about `at` touches.
struct Shares {
    std::size_t first = 0, count = 0;
    std::array<double, 64> share{};
};

double below(double x) noexcept { return 0.5 * std::erfc(-x * std::numbers::sqrt2 / 2); }

// Interval 0 is what lies before the first edge.
void find_shares(const std::vector<double>& edges, double at, double sigma, Shares& out) noexcept {
    const auto from = std::ranges::lower_bound(edges, at - reach_sigma * sigma);
    out.first = static_cast<std::size_t>(from - edges.begin());
    out.count = 0;
    double last = 0;
    for (auto e = from;; ++e) {
        const bool end =
            e == edges.end() || *e > at + reach_sigma * sigma || out.count + 1 == out.share.size();
        const double next = end ? 1 : below((*e - at) / sigma);
        out.share[out.count++] = next - last;
        if (end) return;
        last = next;
    }
}

class BoardPainter {
public:
    BoardPainter(const Board& board, const BoardLight& light)
        : board_{board},
          light_{light},
          edges_x_{edges_of(board, board.columns)},
          edges_y_{edges_of(board, board.rows)} {}

    double grey(const Point& at, const Point& sigma) noexcept {
        find_shares(edges_x_, at[0], sigma[0], x_);
        find_shares(edges_y_, at[1], sigma[1], y_);
        double sum = 0;
        for (std::size_t j = 0; j < y_.count; ++j)
            for (std::size_t i = 0; i < x_.count; ++i)
                sum += y_.share[j] * x_.share[i] * value(x_.first + i, y_.first + j);
        return sum;
    }

private:
    // Intervals: ground, margin, the board's cells, margin, ground.
    [[nodiscard]] double value(std::size_t i, std::size_t j) const noexcept {
        const int x = static_cast<int>(i) - 2, y = static_cast<int>(j) - 2;
        const int wide = cells_of_square * board_.columns, high = cells_of_square * board_.rows;
        if (x < -1 || y < -1 || x > wide || y > high) return light_.ground;
        if (x < 0 || y < 0 || x >= wide || y >= high) return light_.light;
        return dark_cell(board_, x, y) ? light_.dark : light_.light;
    }

    Board board_;
    BoardLight light_;
    std::vector<double> edges_x_, edges_y_;
    Shares x_, y_;
};

}  // namespace

Point BoardPose::place_of(const Point& p) const noexcept {
    const double c = std::cos(turn_rad), s = std::sin(turn_rad);
    return {origin_mm[0] + c * p[0] - s * p[1], origin_mm[1] + s * p[0] + c * p[1]};
}

Point BoardPose::on_board(const Point& place) const noexcept {
    const double c = std::cos(turn_rad), s = std::sin(turn_rad);
    const double a = place[0] - origin_mm[0], b = place[1] - origin_mm[1];
    return {c * a + s * b, c * b - s * a};
}

std::vector<std::uint8_t> board_picture(const Board& board, const View& view, const BoardPose& pose,
                                        int width, int height, const BoardLight& light, std::uint64_t seed) {
    std::mt19937_64 random{seed};
    std::normal_distribution<double> noise{0, light.noise_dn};
    const double blur = std::sqrt(light.psf_px * light.psf_px + 1.0 / 12);  // of lens and pixel
    BoardPainter painter{board, light};
    const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
    // One row and column more: the differences are the local scale.
    std::vector<Point> places((w + 1) * (h + 1));
    for (std::size_t y = 0; y <= h; ++y)
        for (std::size_t x = 0; x <= w; ++x)
            places[y * (w + 1) + x] = pose.on_board(
                place_at(view, pose.offset_mm, {static_cast<double>(x), static_cast<double>(y)}));
    std::vector<std::uint8_t> picture(w * h);
    for (std::size_t y = 0; y < h; ++y)
        for (std::size_t x = 0; x < w; ++x) {
            const Point &at = places[y * (w + 1) + x], &right = places[y * (w + 1) + x + 1],
                        &under = places[(y + 1) * (w + 1) + x];
            const Point sigma{blur * std::hypot(right[0] - at[0], under[0] - at[0]),
                              blur * std::hypot(right[1] - at[1], under[1] - at[1])};
            const double u = 2.0 * static_cast<double>(x) / width - 1;
            double dn = std::isfinite(at[0] + at[1]) ? painter.grey(at, sigma) : light.ground;
            dn = dn * (1 - light.gradient * (0.5 - 0.5 * u)) + (light.noise_dn > 0 ? noise(random) : 0);
            picture[y * w + x] = static_cast<std::uint8_t>(std::lround(std::clamp(dn, 0.0, 255.0)));
        }
    return picture;
}

}  // namespace shaker::optics
