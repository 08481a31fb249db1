#include "tracking/image/ring_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace shaker::tracking {

// Share of the rim in view. A disc whose upper and lower edge are outside the picture shows two arcs.
constexpr double least_rim = 0.2;

RingSearch::RingSearch(double radius, double blur, double sign)
    : sign_{sign}, apart_{std::max(3.0, 0.9 * radius)}, step_{radius < 8 ? 1 : 2} {
    const double margin = std::max(1.5, 2 * blur) + 0.5 * step_;
    const double inside = std::max(radius - margin, 0.5 * radius);
    const int count = std::clamp(static_cast<int>(2 * radius), 16, 48);
    const auto whole_px = [](double r) { return static_cast<int>(std::lround(r)); };
    for (int k = 0; k < count; ++k) {
        // Opposite points follow each other, so the early exit below has soon sampled the whole rim.
        const int order = (k * 5) % count + (count % 5 == 0 ? (k * 5) / count : 0);
        const double angle = 2 * std::numbers::pi * order / count;
        const double c = std::cos(angle), s = std::sin(angle);
        pairs_.push_back({whole_px(inside * c), whole_px(inside * s), whole_px((radius + margin) * c),
                          whole_px((radius + margin) * s)});
    }
}

template <class P>
double RingSearch::score_at(const P& pixels, const Box& image, int x, int y, double contrast) const {
    const double scale = sign_ / contrast;
    double sum = 0;
    int n = 0, seen = 0;
    for (const Pair& p : pairs_) {
        if (++seen == 9 && n > 4 && sum < 0.2 * n) return 0;
        if (!image.contains(x + p.in_x, y + p.in_y) || !image.contains(x + p.out_x, y + p.out_y)) continue;
        const double difference = pixels.at(x + p.in_x, y + p.in_y) - pixels.at(x + p.out_x, y + p.out_y);
        sum += std::clamp(scale * difference, -1.0, 1.0);
        ++n;
    }
    return n < least_rim * static_cast<double>(pairs_.size()) ? 0 : sum / n;
}

double RingSearch::score(const ImageView& image, int x, int y, double contrast) const {
    return with_pixels(image, [&](auto pixels) { return score_at(pixels, whole(image), x, y, contrast); });
}

void RingSearch::scan(const ImageView& image, const Box& box, double contrast, double least,
                      std::vector<RingPeak>& out) {
    out.clear();
    const int columns = (box.x1 - box.x0 + step_ - 1) / step_, rows = (box.y1 - box.y0 + step_ - 1) / step_;
    if (columns <= 0 || rows <= 0) return;
    scores_.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0.0);
    const auto index = [&](int i, int j) {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
    };
    with_pixels(image, [&](auto pixels) {
        for (int j = 0; j < rows; ++j) {
            for (int i = 0; i < columns; ++i) {
                scores_[index(i, j)] =
                    score_at(pixels, whole(image), box.x0 + step_ * i, box.y0 + step_ * j, contrast);
            }
        }
    });
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const double s = scores_[index(i, j)];
            if (s < least) continue;
            const double x = box.x0 + step_ * i, y = box.y0 + step_ * j;
            out.push_back({{x, y}, s});
        }
    }
    std::stable_sort(out.begin(), out.end(), [](auto& a, auto& b) { return a.score > b.score; });
    std::size_t kept = 0;
    for (std::size_t k = 0; k < out.size() && kept < 64; ++k) {
        const auto near = [&](const RingPeak& p) { return length(p.at - out[k].at) < apart_; };
        if (std::none_of(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(kept), near))
            out[kept++] = out[k];
    }
    out.resize(kept);
}

}  // namespace shaker::tracking
