#include "drivers/optics/board.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace shaker::optics {

namespace {

// DICT_4X4_250: four rows of four bits, the first in the highest; 1 is light.
constexpr std::array<std::uint16_t, markers> marker_bits{
    0xb532, 0x0f9a, 0x332d, 0x9946, 0x549e, 0x79cd, 0x9e2e, 0xc4f2, 0xfeda, 0xcf56, 0xf991, 0x11a7, 0x0eb7,
    0x2a0f, 0x24b1, 0x263e, 0x4665, 0x6600, 0x6c5e, 0x76af, 0x868b, 0xb02b, 0xccd5, 0xdd82, 0xfe47, 0x9471,
    0xace4, 0xa554, 0x2123, 0x346f, 0x4415, 0x57b2, 0x9ecf, 0xf0cb, 0x08ae, 0x0929, 0x1875, 0x04ff, 0x0df6,
    0x1c5a, 0x1718, 0x2a28, 0x328c, 0x38b2, 0x24e8, 0x2eeb, 0x2d3f, 0x4b64, 0x502e, 0x5013, 0x5194, 0x5568,
    0x5d41, 0x5f97, 0x6801, 0x6867, 0x6124, 0x61e9, 0x6b12, 0x6fe5, 0x67df, 0x7e1b, 0x80a0, 0x8344, 0x8ba2,
    0x937a, 0x846c, 0x852a, 0x859c, 0x9c89, 0x9fa1, 0xbb7c, 0xbc04, 0xb65b, 0xbfc8, 0xb7ab, 0xca1f, 0xc962,
    0xd958, 0xd3d5, 0xcc98, 0xc7a0, 0xc537, 0xe95d, 0xf925, 0xfbbb, 0xee2a, 0xf74d, 0x3575, 0x8aad, 0x7617,
    0x0acf, 0x064b, 0x2dc1, 0x49d8, 0x43f4, 0x4f36, 0x4fd3, 0x69e4, 0x70c7, 0x7a6e, 0xb4ea, 0xed4f, 0xfce7,
    0xfea6, 0x0025, 0x0043, 0x0a88, 0x0a86, 0x026f, 0x001c, 0x0097, 0x0837, 0x0a31, 0x09c6, 0x0b01, 0x09fb,
    0x0b58, 0x1082, 0x182d, 0x1078, 0x1073, 0x1274, 0x12b1, 0x1af9, 0x1306, 0x0c0e, 0x0cf1, 0x0433, 0x0c9f,
    0x0ef2, 0x0efd, 0x074c, 0x0fa4, 0x072f, 0x05b5, 0x0f91, 0x07db, 0x1ee4, 0x1439, 0x1d80, 0x15c8, 0x1f8b,
    0x15ba, 0x1db1, 0x2080, 0x28e9, 0x22a2, 0x2853, 0x2af0, 0x22f7, 0x2940, 0x2146, 0x29b9, 0x2b9c, 0x2bb2,
    0x38ca, 0x382e, 0x3007, 0x38e7, 0x3a49, 0x3a65, 0x325d, 0x3b88, 0x391d, 0x3bd3, 0x2647, 0x2780, 0x2faa,
    0x2d14, 0x25de, 0x2553, 0x2f77, 0x3448, 0x3ca8, 0x3c41, 0x340d, 0x34fb, 0x369a, 0x3de0, 0x356a, 0x3d09,
    0x3ded, 0x3fc4, 0x3f6c, 0x37ce, 0x3d5c, 0x3d76, 0x37b0, 0x3f17, 0x3fff, 0x48e5, 0x4268, 0x4a2d, 0x4160,
    0x4951, 0x41dd, 0x4bdf, 0x584f, 0x5a48, 0x5816, 0x505d, 0x5afa, 0x5ab5, 0x5123, 0x5b8a, 0x5919, 0x5135,
    0x4c69, 0x46c1, 0x4e0b, 0x445f, 0x4e59, 0x4d83, 0x4d7d, 0x47d8, 0x4773, 0x5c85, 0x5e44, 0x562b, 0x5cbb,
    0x55c3, 0x5f6e, 0x5feb, 0x5d12, 0x555e, 0x6270, 0x6215, 0x61c2, 0x6b20, 0x6345, 0x6b5c, 0x6b5b, 0x780c,
    0x7acf, 0x787f, 0x7980, 0x71e5, 0x7174, 0x79b6, 0x71d3, 0x7b33, 0x646a, 0x66a8, 0x6ea7, 0x6e91, 0x6522,
    0x6dcb, 0x678d, 0x6d31};

constexpr int marker_cells = 6;  // with its dark frame

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

double cell_edge(const Board& board, int cell) noexcept {
    if (cell == 0) return 0;
    return 0.5 * (board.square_mm - board.marker_mm) + board.marker_mm * (cell - 1) / marker_cells;
}

bool dark_cell(const Board& board, int x, int y) noexcept {
    const int column = x / cells_of_square, row = y / cells_of_square;
    if ((column + row) % 2 == 0) return true;
    const int cell_x = x % cells_of_square - 1, cell_y = y % cells_of_square - 1;
    if (cell_x < 0 || cell_y < 0 || cell_x >= marker_cells || cell_y >= marker_cells) return false;
    const int bit_x = cell_x - 1, bit_y = cell_y - 1, bits = marker_cells - 2;
    if (bit_x < 0 || bit_y < 0 || bit_x >= bits || bit_y >= bits) return true;
    const auto pattern = marker_bits[static_cast<std::size_t>(board.marker_of(column, row)) % markers];
    return ((pattern >> (15 - bits * bit_y - bit_x)) & 1) == 0;
}

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
