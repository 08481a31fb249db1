#include "calibration/camera/corner_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace shaker::calibration {

namespace {

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

}  // namespace

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

}  // namespace shaker::calibration
