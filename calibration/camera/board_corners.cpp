#include "calibration/camera/board_corners.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>

#include "drivers/codecs/codecs.hpp"

namespace shaker::calibration {

namespace {

/// Where a corner is expected.
struct ExpectedCorner {
    std::array<double, 2> at_px{};
    std::array<double, 2> x_px{}, y_px{};  // image of the board's x and y over one square
    double quiet_share = 0.15;             // margin around a marker over the square
};

struct FittedCorner {
    std::array<double, 2> at_px{};
    double rms = 0;       // of the grey levels about the model, over its amplitude
    double blur = 0;      // sigma, px
    double reach_px = 0;  // length of either edge that was looked at, to either side
};

constexpr int unknowns = 9;  // x, y, angle of either edge, blur, level, amplitude, slopes of the level
using Vector9 = Eigen::Matrix<double, unknowns, 1>;
using Matrix9 = Eigen::Matrix<double, unknowns, unknowns>;

struct Pixel {
    double x, y, grey;
};

double distance(const std::array<double, 2>& axis, double dx, double dy) {
    return (axis[0] * dy - axis[1] * dx) / std::hypot(axis[0], axis[1]);
}

double reach_of(const ExpectedCorner& e) {
    constexpr double most_reach = 6;
    return std::min(most_reach,
                    0.5 * std::min(std::hypot(e.x_px[0], e.x_px[1]), std::hypot(e.y_px[0], e.y_px[1])) - 1);
}

// Pixels around the edges; none that a marker touches or that lies beyond half a square.
std::vector<Pixel> pixels_near(const GreyPicture& picture, const ExpectedCorner& e) {
    constexpr double blur_margin = 2;
    const double square = std::min(std::hypot(e.x_px[0], e.x_px[1]), std::hypot(e.y_px[0], e.y_px[1]));
    const double reach = reach_of(e);
    const double quiet = std::max(2.0, e.quiet_share * square - blur_margin + 1);
    const int span = static_cast<int>(1.5 * reach) + 1;
    const int cx = static_cast<int>(std::lround(e.at_px[0])), cy = static_cast<int>(std::lround(e.at_px[1]));
    std::vector<Pixel> pixels;
    for (int y = cy - span; y <= cy + span; ++y)
        for (int x = cx - span; x <= cx + span; ++x) {
            const double d1 = std::abs(distance(e.x_px, x - e.at_px[0], y - e.at_px[1]));
            const double d2 = std::abs(distance(e.y_px, x - e.at_px[0], y - e.at_px[1]));
            if (std::max(d1, d2) > reach || std::min(d1, d2) > quiet) continue;
            if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return {};
            pixels.push_back({static_cast<double>(x), static_cast<double>(y), picture.at(x, y)});
        }
    return pixels;
}

struct Step {
    Matrix9 normal = Matrix9::Zero();
    Vector9 gradient = Vector9::Zero();
    double squares = 0;
};

Step linearised(const std::vector<Pixel>& pixels, const Vector9& p) {
    const double s1 = std::sin(p[2]), c1 = std::cos(p[2]), s2 = std::sin(p[3]), c2 = std::cos(p[3]);
    const double width = std::numbers::sqrt2 * p[4];
    Step step;
    for (const Pixel& pixel : pixels) {
        const double dx = pixel.x - p[0], dy = pixel.y - p[1];
        const double z1 = (c1 * dy - s1 * dx) / width, z2 = (c2 * dy - s2 * dx) / width;
        const double e1 = std::erf(z1), e2 = std::erf(z2);
        const double k = 2 * std::numbers::inv_sqrtpi * p[6];
        const double f1 = k * std::exp(-z1 * z1) * e2, f2 = k * std::exp(-z2 * z2) * e1;
        Vector9 j;
        j << (f1 * s1 + f2 * s2) / width - p[7], -(f1 * c1 + f2 * c2) / width - p[8],
            -f1 * (s1 * dy + c1 * dx) / width, -f2 * (s2 * dy + c2 * dx) / width, -(f1 * z1 + f2 * z2) / p[4],
            1, e1 * e2, dx, dy;
        const double off = pixel.grey - (p[5] + p[6] * e1 * e2 + p[7] * dx + p[8] * dy);
        step.normal.noalias() += j * j.transpose();
        step.gradient += off * j;
        step.squares += off * off;
    }
    return step;
}

Vector9 start_of(const std::vector<Pixel>& pixels, const ExpectedCorner& e) {
    double sum = 0, product = 0, count = 0;
    const auto n = static_cast<double>(pixels.size());
    for (const Pixel& p : pixels) sum += p.grey / n;
    for (const Pixel& p : pixels) {
        const double d1 = distance(e.x_px, p.x - e.at_px[0], p.y - e.at_px[1]);
        const double d2 = distance(e.y_px, p.x - e.at_px[0], p.y - e.at_px[1]);
        product += std::copysign(1.0, d1 * d2) * (p.grey - sum);
        ++count;
    }
    Vector9 start;
    start << e.at_px[0], e.at_px[1], std::atan2(e.x_px[1], e.x_px[0]), std::atan2(e.y_px[1], e.y_px[0]), 1,
        sum, product / count, 0, 0;
    return start;
}

/// Fits I(p) = a + g . (p - c) + b erf(d_1 / (sqrt(2) s)) erf(d_2 / (sqrt(2) s)) to the grey levels around
/// the corner c, with d_1, d_2 the distances from its two edges, which may have any angle. A blur that is
/// symmetric does not move c, however large. Pixels that a marker may touch are left out. Empty when the fit
/// does not converge near the expected place, or the levels are not those of a corner.
std::optional<FittedCorner> fit_corner(const GreyPicture& picture, const ExpectedCorner& expected) {
    constexpr int most_steps = 25;
    constexpr double still_px = 1e-5, least_amplitude = 8, most_rms = 0.25, least_blur = 0.2, most_blur = 6;
    ExpectedCorner e = expected;
    const double square = std::min(std::hypot(e.x_px[0], e.x_px[1]), std::hypot(e.y_px[0], e.y_px[1]));
    Vector9 p;
    double rms = 0;
    for (int pass = 0; pass < 2; ++pass) {  // the second with the pixels around the place of the first
        const std::vector<Pixel> pixels = pixels_near(picture, e);
        if (pixels.size() < 4 * unknowns) return std::nullopt;
        p = start_of(pixels, e);
        double damping = 1e-3;
        Step now = linearised(pixels, p);
        for (int i = 0; i < most_steps; ++i) {
            Matrix9 damped = now.normal;
            damped.diagonal() *= 1 + damping;
            const Vector9 move = damped.ldlt().solve(now.gradient);
            Vector9 next = p + move;
            next[4] = std::clamp(next[4], least_blur, most_blur);
            const Step then = linearised(pixels, next);
            if (!(then.squares <= now.squares)) {
                damping *= 10;
                if (damping > 1e8) break;
                continue;
            }
            p = next;
            now = then;
            damping *= 0.1;
            if (std::hypot(move[0], move[1]) < still_px) break;
        }
        if (!(std::hypot(p[0] - e.at_px[0], p[1] - e.at_px[1]) < 0.3 * square)) return std::nullopt;
        e.at_px = {p[0], p[1]};
        rms = std::sqrt(now.squares / static_cast<double>(pixels.size() - unknowns));
    }
    const double amplitude = std::abs(p[6]);
    if (!(amplitude > least_amplitude && rms < most_rms * amplitude) || p[4] >= most_blur)
        return std::nullopt;
    return FittedCorner{.at_px = {p[0], p[1]}, .rms = rms / amplitude, .blur = p[4], .reach_px = reach_of(e)};
}

using optics::Board;
// Corners of a marker: top left, top right, bottom right, bottom left.
using Corners = std::array<std::array<double, 2>, 4>;

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

GreyPicture grey_picture(const ImageView& image) {
    GreyPicture picture{.width = image.width, .height = image.height};
    picture.grey.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    float most = 1;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const std::byte* at = image.row(y) + std::ptrdiff_t{x} * image.bytes_per_pixel;
            float grey = std::to_integer<std::uint8_t>(*at);
            if (image.bytes_per_pixel == 2) {
                std::uint16_t wide{};
                std::memcpy(&wide, at, sizeof wide);
                grey = wide;
            }
            most = std::max(most, grey);
            picture.grey.push_back(grey);
        }
    if (image.bytes_per_pixel == 2)
        for (float& g : picture.grey) g *= 255 / most;
    return picture;
}

GreyPicture read_picture(const std::filesystem::path& file) {
    constexpr std::array<float, 3> weights{0.114F, 0.587F, 0.299F};  // blue, green, red
    const cv::Mat image = codecs::read_pages(file.string(), 0, 1).front();
    const int channels = image.channels();
    const bool wide = image.depth() == CV_16U;
    GreyPicture picture{.width = image.cols, .height = image.rows};
    float most = 1;
    for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x) {
            float grey = 0;
            for (int k = 0; k < std::min(channels, 3); ++k) {
                const int at = channels * x + k;
                const float value = wide ? image.ptr<std::uint16_t>(y)[at] : image.ptr<std::uint8_t>(y)[at];
                grey += channels < 3 ? (k == 0 ? value : 0) : weights[static_cast<std::size_t>(k)] * value;
            }
            most = std::max(most, grey);
            picture.grey.push_back(grey);
        }
    if (wide)
        for (float& g : picture.grey) g *= 255 / most;
    return picture;
}

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
