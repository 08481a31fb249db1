#include "tracking/image/ring_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>

#include "tracking/image/profile.hpp"

namespace shaker::tracking {
namespace {

// Share of the rim in view. A disc whose upper and lower edge are outside the picture shows two arcs.
constexpr double least_rim = 0.2;
constexpr int full_contrast = 128;     // in the reduced picture
constexpr double reduced_radius = 12;  // px of the reduced picture, at least
constexpr int largest_cell = 16, most_rows_of_a_cell = 4;
constexpr std::size_t most_peaks = 64;
constexpr double lanes_at_a_time = 6e5;  // centres x pixel pairs tested in one call, about 0.1 ms

// sums[i] += inside[i] - outside[i], at most the contrast.
void add_differences(const std::int16_t* inside, const std::int16_t* outside, int n, std::int16_t* sums) {
    constexpr int lanes = 8;
    using Eight [[gnu::vector_size(16)]] = std::int16_t;
    const Eight most = Eight{} + std::int16_t{full_contrast}, least = -most;
    int i = 0;
    for (; i + lanes <= n; i += lanes) {
        Eight a, b, sum;
        std::memcpy(&a, inside + i, sizeof a);
        std::memcpy(&b, outside + i, sizeof b);
        std::memcpy(&sum, sums + i, sizeof sum);
        Eight off = a - b;
        off = off > most ? most : off;
        off = off < least ? least : off;
        sum += off;
        std::memcpy(sums + i, &sum, sizeof sum);
    }
    for (; i < n; ++i)
        sums[i] = static_cast<std::int16_t>(
            sums[i] + std::clamp(inside[i] - outside[i], -full_contrast, full_contrast));
}

}  // namespace

RingSearch::RingSearch(double radius, double blur, double sign)
    : sign_{sign},
      apart_{std::max(3.0, 0.9 * radius)},
      cell_{std::clamp(static_cast<int>(radius / reduced_radius), 1, largest_cell)},
      pairs_{ring(radius, std::max(1.5, 2 * blur) + (radius < 8 ? 0.5 : 1))},
      reduced_pairs_{ring(radius / cell_, std::max(1.5, 2 * blur / cell_) + (cell_ > 1 ? 0.5 : 0))} {}

std::vector<RingSearch::Pair> RingSearch::ring(double radius, double margin) {
    const double inside = std::max(radius - margin, 0.5 * radius);
    const int count = std::clamp(static_cast<int>(3 * radius), 16, 48);
    const auto whole_px = [](double r) { return static_cast<int>(std::lround(r)); };
    std::vector<Pair> pairs;
    for (int k = 0; k < count; ++k) {
        const double angle = 2 * std::numbers::pi * k / count;
        const double c = std::cos(angle), s = std::sin(angle);
        pairs.push_back({whole_px(inside * c), whole_px(inside * s), whole_px((radius + margin) * c),
                         whole_px((radius + margin) * s)});
    }
    return pairs;
}

int RingSearch::rows_at_a_time(int width) const noexcept {
    const double row = (1.0 * width / cell_ + 1) * static_cast<double>(reduced_pairs_.size());
    return std::max(1, static_cast<int>(lanes_at_a_time / row)) * cell_;
}

double RingSearch::score(const ImageView& image, int x, int y, double contrast) const {
    const double scale = sign_ / contrast;
    const Box box = whole(image);
    double sum = 0;
    int n = 0;
    with_pixels(image, [&](auto pixels) {
        for (const Pair& p : pairs_) {
            if (!box.contains(x + p.in_x, y + p.in_y) || !box.contains(x + p.out_x, y + p.out_y)) continue;
            const double off = pixels.at(x + p.in_x, y + p.in_y) - pixels.at(x + p.out_x, y + p.out_y);
            sum += std::clamp(scale * off, -1.0, 1.0);
            ++n;
        }
    });
    return n < least_rim * static_cast<double>(pairs_.size()) ? 0 : sum / n;
}

Point RingSearch::refine(const ImageView& image, Point peak, double contrast) const {
    int x = static_cast<int>(std::lround(peak.x)), y = static_cast<int>(std::lround(peak.y));
    double best = score(image, x, y, contrast);
    for (int step = std::max(1, cell_ / 2); step > 0; step /= 2) {
        for (bool moved = true; moved;) {
            moved = false;
            const int from_x = x, from_y = y;
            for (int j = -step; j <= step; j += step) {
                for (int i = -step; i <= step; i += step) {
                    const double s = score(image, from_x + i, from_y + j, contrast);
                    if (s > best) best = s, x = from_x + i, y = from_y + j, moved = true;
                }
            }
        }
    }
    return {static_cast<double>(x), static_cast<double>(y)};
}

// The part of the picture that rings about the centres of `box` reach.
void RingSearch::reduce(const ImageView& image, const Box& box, double contrast) {
    int reach = 0;
    for (const Pair& p : reduced_pairs_) reach = std::max({reach, p.out_x, p.out_y});
    const auto first = [&](int from) { return std::max(0, from / cell_ - reach - 1); };
    const auto end = [&](int to, int size) { return std::min(size / cell_, to / cell_ + reach + 2); };
    x0_ = first(box.x0);
    y0_ = first(box.y0);
    columns_ = std::max(0, end(box.x1, image.width) - x0_);
    rows_ = std::max(0, end(box.y1, image.height) - y0_);
    const auto across = static_cast<std::size_t>(columns_), cell = static_cast<std::size_t>(cell_);
    levels_.resize(across * static_cast<std::size_t>(rows_));
    means_.resize(across * cell);
    if (levels_.empty()) return;
    const int taken = std::min(cell_, most_rows_of_a_cell);
    const double scale = sign_ * full_contrast / contrast;
    double middle = 0;  // of the first row: keeps levels small
    for (int j = 0; j < rows_; ++j) {
        const int row = (y0_ + j) * cell_ + (cell_ - taken) / 2;
        mean_profile(image, Axis::x, x0_ * cell_, row, row + taken, means_);
        if (j == 0)
            middle = std::accumulate(means_.begin(), means_.end(), 0.0) / static_cast<double>(means_.size());
        for (std::size_t i = 0; i < across; ++i) {
            const auto from = means_.begin() + static_cast<std::ptrdiff_t>(i * cell);
            const double mean = std::accumulate(from, from + cell_, 0.0) / cell_;
            levels_[static_cast<std::size_t>(j) * across + i] =
                static_cast<std::int16_t>(std::clamp(scale * (mean - middle), -16000.0, 16000.0));
        }
    }
}

// Sums over the pairs for `count` centres of the reduced picture's row y, from column `first`.
void RingSearch::score_row(int y, int first, int count) {
    sums_.assign(static_cast<std::size_t>(count), 0);
    seen_.assign(static_cast<std::size_t>(count) + 1, 0);
    for (const Pair& p : reduced_pairs_) {
        const int in_row = y + p.in_y, out_row = y + p.out_y;
        if (std::min(in_row, out_row) < 0 || std::max(in_row, out_row) >= rows_) continue;
        const int from = std::max(first, -std::min(p.in_x, p.out_x));
        const int end = std::min(first + count, columns_ - std::max(p.in_x, p.out_x));
        if (from >= end) continue;
        const std::int16_t* const inside = levels_.data() + std::ptrdiff_t{in_row} * columns_ + p.in_x + from;
        const std::int16_t* const outside =
            levels_.data() + std::ptrdiff_t{out_row} * columns_ + p.out_x + from;
        add_differences(inside, outside, end - from, sums_.data() + (from - first));
        ++seen_[static_cast<std::size_t>(from - first)];
        --seen_[static_cast<std::size_t>(end - first)];
    }
}

void RingSearch::scan(const ImageView& image, const Box& box, double contrast, double least,
                      std::vector<RingPeak>& out) {
    out.clear();
    reduce(image, box, contrast);
    if (levels_.empty()) return;
    const auto down = [&](int px) { return px >= 0 ? px / cell_ : -((cell_ - 1 - px) / cell_); };
    const int first = down(box.x0) - x0_, count = down(box.x1 - 1) - x0_ - first + 1;
    const auto enough =
        static_cast<int>(std::ceil(0.7 * least_rim * static_cast<double>(reduced_pairs_.size())));
    const double middle = 0.5 * (cell_ - 1);
    for (int y = down(box.y0); y <= down(box.y1 - 1) && count > 0; ++y) {
        score_row(y - y0_, first, count);
        int seen = 0;
        for (int i = 0; i < count; ++i) {
            seen += seen_[static_cast<std::size_t>(i)];
            const int sum = sums_[static_cast<std::size_t>(i)];
            if (seen < enough || sum < least * full_contrast * seen) continue;
            out.push_back({{(first + x0_ + i) * cell_ + middle, y * cell_ + middle},
                           static_cast<double>(sum) / (full_contrast * seen)});
        }
    }
    keep_peaks(out);
}

// The best centres that are apart from each other, each in the middle of those about it that are as good.
void RingSearch::keep_peaks(std::vector<RingPeak>& all) const {
    std::stable_sort(all.begin(), all.end(), [](auto& a, auto& b) { return a.score > b.score; });
    std::array<RingPeak, most_peaks> kept{};
    std::array<Point, most_peaks> sum{};
    std::array<double, most_peaks> count{};
    std::size_t n = 0;
    for (const RingPeak& p : all) {
        std::size_t k = 0;
        while (k < n && length(p.at - kept[k].at) >= apart_) ++k;
        if (k == n) {
            if (n == most_peaks) break;
            kept[n++] = p;
        }
        if (length(p.at - kept[k].at) > 3 * cell_ || p.score < 0.9 * kept[k].score) continue;
        sum[k] = sum[k] + p.at;
        count[k] += 1;
    }
    for (std::size_t k = 0; k < n; ++k) kept[k].at = (1 / count[k]) * sum[k];
    all.assign(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(n));
}

}  // namespace shaker::tracking
