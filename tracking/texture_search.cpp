#include "tracking/texture_search.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace shaker::tracking {

namespace {

constexpr int largest_cell = 16, fewest_cells = 8;  // fewest_cells: along the shorter side
constexpr double detail_kept = 0.6;                 // of the contrast, from one size of cell to twice that
constexpr double most_cells = 600;                  // of the texture; a larger one is compared in its middle
constexpr std::size_t most_peaks = 24;
constexpr double cells_at_a_time = 4500;  // of the picture, about 0.1 ms

// Means of the cells of a box whose sides are multiples of a cell.
cv::Mat1f reduced(const ImageView& image, const Box& box, int cell) {
    const cv::Mat whole_image{image.height, image.width, image.bytes_per_pixel == 2 ? CV_16UC1 : CV_8UC1,
                              const_cast<std::byte*>(image.pixels), static_cast<std::size_t>(image.stride)};
    const cv::Mat part = whole_image(cv::Rect{box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0});
    cv::Mat small;
    cv::resize(part, small, {part.cols / cell, part.rows / cell}, 0, 0, cv::INTER_AREA);
    cv::Mat1f out;
    small.convertTo(out, CV_32F);
    return out;
}

// The middle of a range, of a length that is a multiple of a cell.
void trim(int& first, int& last, int cell, int most) {
    const int length = std::min((last - first) / cell, most) * cell;
    first += (last - first - length) / 2;
    last = first + length;
}

double contrast_of(const cv::Mat1f& levels) {
    cv::Scalar mean, sd;
    cv::meanStdDev(levels, mean, sd);
    return sd[0];
}

}  // namespace

TextureSearch::TextureSearch(const ImageView& image, const Box& box) {
    for (int cell = 1; cell <= largest_cell; cell *= 2) {
        Box part = box;
        const double width = part.x1 - part.x0, height = part.y1 - part.y0;
        const double too_large = std::sqrt(std::max(1.0, width * height / (cell * cell * most_cells)));
        const auto most = [&](double side) {
            return std::max(fewest_cells, static_cast<int>(side / cell / too_large));
        };
        trim(part.x0, part.x1, cell, most(width));
        trim(part.y0, part.y1, cell, most(height));
        if (cell > 1 && std::min(part.x1 - part.x0, part.y1 - part.y0) < fewest_cells * cell) return;
        cv::Mat1f texture = reduced(image, part, cell);
        if (cell > 1 && contrast_of(texture) < detail_kept * contrast_of(texture_)) return;
        texture_ = std::move(texture);
        box_ = part;
        cell_ = cell;
    }
}

// A tile of t cells reads (t + columns) (t + rows) cells of the picture.
int TextureSearch::tile() const noexcept {
    const double columns = texture_.cols, rows = texture_.rows, off = columns - rows;
    return std::max(
               4, static_cast<int>(std::sqrt(cells_at_a_time + 0.25 * off * off) - 0.5 * (columns + rows))) *
           cell_;
}

void TextureSearch::scan(const ImageView& image, const Box& shifts, double least,
                         std::vector<TexturePeak>& out) const {
    out.clear();
    Box area{std::max(0, box_.x0 + shifts.x0), std::max(0, box_.y0 + shifts.y0),
             std::min(image.width, box_.x1 + shifts.x1), std::min(image.height, box_.y1 + shifts.y1)};
    area.x1 = area.x0 + (area.x1 - area.x0) / cell_ * cell_;
    area.y1 = area.y0 + (area.y1 - area.y0) / cell_ * cell_;
    if (area.x1 - area.x0 < texture_.cols * cell_ || area.y1 - area.y0 < texture_.rows * cell_) return;
    cv::Mat1f score;
    cv::matchTemplate(reduced(image, area, cell_), texture_, score, cv::TM_CCOEFF_NORMED);
    while (out.size() < most_peaks) {
        double best = 0;
        cv::Point at;
        cv::minMaxLoc(score, nullptr, &best, nullptr, &at);
        if (!(best > least)) break;
        out.push_back(
            {{1.0 * area.x0 + at.x * cell_ - box_.x0, 1.0 * area.y0 + at.y * cell_ - box_.y0}, best});
        const int r = std::max(1, std::min(texture_.cols, texture_.rows) / 2);
        score(cv::Rect{at.x - r, at.y - r, 2 * r + 1, 2 * r + 1} & cv::Rect{0, 0, score.cols, score.rows})
            .setTo(0);
    }
}

}  // namespace shaker::tracking
