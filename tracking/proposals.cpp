#include "tracking/proposals.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "drivers/errors.hpp"
#include "tracking/image/pixels.hpp"
#include "tracking/tracker.hpp"

namespace shaker::tracking {

namespace {

constexpr std::size_t most_targets = 12, most_refused = 24;
constexpr int least_side = 6, least_area = 30;  // px
constexpr double small_disc = 10;               // px; a smaller one is a dot
constexpr double alike = 0.1;                   // of a length, between members of a row
constexpr double full_from = 0.9, round_to = 0.07, square_to = 0.15;

enum class Form { round, straight };

/// A connected region that is brighter, or darker, than the threshold.
struct Blob {
    Form form{};
    Polarity polarity{};
    Box box{};
    double diameter = 0;  // of a round one, px
    bool whole = false;   // no side at the edge of the picture
    [[nodiscard]] int width() const { return box.x1 - box.x0; }
    [[nodiscard]] int height() const { return box.y1 - box.y0; }
    [[nodiscard]] double x() const { return 0.5 * (box.x0 + box.x1 - 1); }
    [[nodiscard]] double y() const { return 0.5 * (box.y0 + box.y1 - 1); }
};

cv::Mat1b in_eight_bits(const ImageView& image) {
    const cv::Mat whole_image{image.height, image.width, image.bytes_per_pixel == 2 ? CV_16UC1 : CV_8UC1,
                              const_cast<std::byte*>(image.pixels), static_cast<std::size_t>(image.stride)};
    cv::Mat smooth, grey;
    cv::GaussianBlur(whole_image, smooth, {3, 3}, 0);
    cv::normalize(smooth, grey, 0, 255, cv::NORM_MINMAX, CV_8U);
    return grey;
}

void add_blobs(const cv::Mat1b& grey, Polarity polarity, std::vector<Blob>& out) {
    cv::Mat mask, labels, stats, centres;
    cv::threshold(
        grey, mask, 0, 255,
        cv::THRESH_OTSU | (polarity == Polarity::bright ? cv::THRESH_BINARY : cv::THRESH_BINARY_INV));
    const int count = cv::connectedComponentsWithStats(mask, labels, stats, centres, 8);
    for (int i = 1; i < count; ++i) {
        const auto stat = [&](int which) { return stats.at<int>(i, which); };
        const int x = stat(cv::CC_STAT_LEFT), y = stat(cv::CC_STAT_TOP);
        const int w = stat(cv::CC_STAT_WIDTH), h = stat(cv::CC_STAT_HEIGHT), area = stat(cv::CC_STAT_AREA);
        if (area < least_area || std::min(w, h) < 2) continue;
        Blob b{.polarity = polarity, .box = {x, y, x + w, y + h}};
        b.whole = x > 0 && y > 0 && x + w < grey.cols && y + h < grey.rows;
        const double full = 1.0 * area / (w * h);
        b.diameter = std::sqrt(4 * area / std::numbers::pi);
        const double rounding = 1.0 / std::min(w, h);
        if (std::abs(full - std::numbers::pi / 4) < round_to + rounding &&
            std::abs(1.0 * w / h - 1) < square_to + rounding)
            b.form = Form::round;
        else if (full > full_from)
            b.form = Form::straight;
        else
            continue;
        out.push_back(b);
    }
}

/// Distance between neighbours, median: the edge of the picture may cut the first and the last one.
double pitch_of(const std::vector<Blob>& row) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < row.size(); ++i) steps.push_back(row[i].x() - row[i - 1].x());
    std::ranges::nth_element(steps, steps.begin() + std::ssize(steps) / 2);
    return steps[steps.size() / 2];
}

bool regular(const std::vector<Blob>& row) {
    const double pitch = pitch_of(row);
    const std::size_t cut = row.size() > 3 ? 1 : 0;  // members at either end, by the edge of the picture
    for (std::size_t i = 1 + cut; i + cut < row.size(); ++i)
        if (std::abs(row[i].x() - row[i - 1].x() - pitch) > alike * pitch + 1) return false;
    return true;
}

Box united(const std::vector<Blob>& row) {
    Box all = row.front().box;
    for (const Blob& b : row)
        all = {std::min(all.x0, b.box.x0), std::min(all.y0, b.box.y0), std::max(all.x1, b.box.x1),
               std::max(all.y1, b.box.y1)};
    return all;
}

/// The same form, size across and height in the picture.
bool same_row(const Blob& a, const Blob& b) {
    if (a.form != b.form || a.polarity != b.polarity) return false;
    if (a.form == Form::round)
        return std::abs(a.diameter - b.diameter) < alike * a.diameter + 1 &&
               std::abs(a.y() - b.y()) < alike * a.diameter + 1;
    constexpr int rows_off = 2;
    return std::abs(a.box.y0 - b.box.y0) <= rows_off && std::abs(a.box.y1 - b.box.y1) <= rows_off;
}

/// Splits blobs into rows, each in the order of x.
std::vector<std::vector<Blob>> rows_of(std::vector<Blob> blobs) {
    std::ranges::sort(blobs, {}, &Blob::x);
    std::vector<std::vector<Blob>> rows;
    for (const Blob& b : blobs) {
        const auto row =
            std::ranges::find_if(rows, [&](const std::vector<Blob>& r) { return same_row(r.front(), b); });
        if (row == rows.end())
            rows.push_back({b});
        else
            row->push_back(b);
    }
    return rows;
}

struct Found {
    Target target{};
    Box box{};
    std::string words{};
    double pitch = 0;         // px, of a row
    std::vector<Blob> row{};  // round ones, to be tried by themselves
};

Found single(const Blob& b) {
    Found f{.box = b.box};
    f.target.polarity = b.polarity;
    if (b.form == Form::straight) {
        f.target.kind = TargetKind::rectangle;
        f.target.width_mm = b.width();
        f.words = fmt::format("a rectangle of {} x {} px", b.width(), b.height());
    } else {
        f.target.kind = b.diameter < small_disc ? TargetKind::dots : TargetKind::disc;
        f.target.diameter_mm = b.diameter;
        f.words = fmt::format("a disc of {:.0f} px", b.diameter);
    }
    return f;
}

void add_singles(const std::vector<Blob>& row, std::vector<Found>& out) {
    for (const Blob& b : row)
        if (b.whole && std::min(b.width(), b.height()) >= least_side) out.push_back(single(b));
}

/// Bars, a code or a row of dots; or each blob by itself.
void add_found(const std::vector<Blob>& row, std::vector<Found>& out) {
    constexpr std::size_t fewest_bars = 4, fewest_dots = 3;
    Found f{.box = united(row)};
    f.target.polarity = row.front().polarity;
    const bool straight = row.front().form == Form::straight;
    if (straight && row.size() >= fewest_bars) {
        const bool periodic = regular(row);
        f.target.kind = periodic ? TargetKind::bars : TargetKind::code;
        f.pitch = pitch_of(row);
        if (periodic) f.target.pitch_mm = f.pitch;
        f.words = fmt::format("{} {} bars", row.size(), periodic ? "regular" : "irregular");
        out.push_back(f);
        return;
    }
    if (!straight && row.size() >= fewest_dots && regular(row)) {
        f.target.kind = TargetKind::dots;
        f.target.diameter_mm = row.front().diameter;
        f.target.pitch_mm = pitch_of(row);
        f.words = fmt::format("a row of {} discs of {:.0f} px", row.size(), row.front().diameter);
        f.row = row;
        out.push_back(f);
        return;
    }
    add_singles(row, out);
}

/// A region with surroundings; of bars and codes without, where they end at the edges of a print.
std::array<int, 4> region_around(const Box& box, TargetKind kind, const ImageView& image) {
    constexpr int least = 6, most = 40;
    const bool printed = kind == TargetKind::bars || kind == TargetKind::code;
    const int margin = std::clamp(std::min(box.x1 - box.x0, box.y1 - box.y0) / 4, least, most);
    const int dx = printed ? 0 : margin, dy = printed ? 0 : margin;
    const int x0 = std::max(0, box.x0 - dx), y0 = std::max(0, box.y0 - dy);
    return {x0, y0, std::min(image.width, box.x1 + dx) - x0, std::min(image.height, box.y1 + dy) - y0};
}

std::string why_not_followed(const Target& target, const ImageView& image) {
    try {
        ViewTracker{View{.camera = "view", .mm_per_px = 1, .targets = {target}}}.update(image, CameraTick{0});
        return {};
    } catch (const InputError& why) {
        return why.what();
    }
}

}  // namespace

Proposals proposed_targets(const ImageView& image) {
    const cv::Mat1b grey = in_eight_bits(image);
    std::vector<Blob> blobs;
    for (const Polarity polarity : {Polarity::bright, Polarity::dark}) add_blobs(grey, polarity, blobs);
    std::vector<Found> found;
    for (const std::vector<Blob>& row : rows_of(std::move(blobs))) add_found(row, found);
    const auto area = [](const Found& f) { return (f.box.x1 - f.box.x0) * (f.box.y1 - f.box.y0); };
    std::ranges::stable_sort(found, std::ranges::greater{}, area);
    Proposals out;
    std::map<TargetKind, int> numbers;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (out.targets.size() == most_targets || out.refused.size() == most_refused) break;
        Found f = std::move(found[i]);
        f.target.name = word(f.target.kind);
        f.target.roi_px = region_around(f.box, f.target.kind, image);
        std::string why = why_not_followed(f.target, image);
        if (!why.empty() && f.target.kind == TargetKind::code) {  // one of its bars may be hidden
            f.target.kind = TargetKind::bars;
            f.target.pitch_mm = f.pitch;
            why = why_not_followed(f.target, image);
        }
        if (!why.empty()) {
            out.refused.push_back(fmt::format("{} at {:.0f}, {:.0f}: {}", f.words,
                                              0.5 * (f.box.x0 + f.box.x1), 0.5 * (f.box.y0 + f.box.y1), why));
            add_singles(f.row, found);
            continue;
        }
        f.target.name = fmt::format("{}{}", word(f.target.kind), ++numbers[f.target.kind]);
        out.targets.push_back(std::move(f.target));
    }
    return out;
}

}  // namespace shaker::tracking
