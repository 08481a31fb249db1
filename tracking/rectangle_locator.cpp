// Locator for a silhouette: its two edges across the shaker's axis.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "tracking/image/profile.hpp"
#include "tracking/outline_locator.hpp"

namespace shaker::tracking {

namespace {

/// Rows between the edges are averaged in groups; each group and edge has its own gain and offset. A
/// silhouette that looks as it did is followed by filters of the means about its edges. Measures along the
/// image axis nearest to the shaker's; the other coordinate is the middle of the rows in use. The width is
/// measured when it is not given.
class RectangleLocator final : public OutlineLocator {
public:
    explicit RectangleLocator(Subject subject)
        : OutlineLocator{std::move(subject), true}, axis_{axis_of(subject_)} {
        most_growth_ = 0.03;
        blocks_ = 2 * groups;
    }
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 10; }
    [[nodiscard]] std::optional<Correction> correction() const override {
        return correction_of("width_mm", subject_.target.width_mm,
                             crossing_px(subject_, subject_.target.width_mm), 2 * learned_.size);
    }
    [[nodiscard]] bool interchangeable() const noexcept override { return true; }

private:
    void gather(const ImageView& image, Point centre, int every) override;
    [[nodiscard]] Sites sites() const override;
    [[nodiscard]] double rim() const noexcept override;
    bool look(const ImageView& image, Point at) override;
    bool find_near(const ImageView& image, Point predicted, Candidate& out) override;
    EdgeFitResult fit_near(const ImageView& image, Point at, Candidate& out) override;
    void find_edges(const Box& box, double given);
    void find_rows(const ImageView& image, int first, int last, double centre);
    [[nodiscard]] double pair_score(double centre) const;
    void doubt_size(double size, Candidate& out) const;
    void load_profile(const ImageView& image) {
        profile_.resize(static_cast<std::size_t>(length_along(image, axis_)));
        mean_profile(image, axis_, 0, row0_, row1_, profile_);
    }
    [[nodiscard]] int group_count() const noexcept { return std::min(groups, row1_ - row0_); }
    [[nodiscard]] Point place(double along) const noexcept;

    static constexpr int groups = 8;  // of rows
    Axis axis_;
    int row0_ = 0, row1_ = 0;
    std::vector<double> profile_, line_;
    std::vector<float> strip_;  // means of each group of rows about the left edge, then about the right one
};

constexpr int window = 10;           // px on either side of an edge that are read
constexpr double reach_of_edge = 8;  // px at which they have faded out, wherever in its pixel the edge is
constexpr int reserve = 4;           // px more in the strip, for the error of a prediction
constexpr int strip_half = window + reserve, strip_side = 2 * strip_half + 1;
constexpr double wide_share = 0.02;         // of the width
constexpr double width_step = 2;            // px of half the width
constexpr int plateau = 5;                  // px on either side of an edge that the coarse search compares
constexpr double sizes_off = 5;             // standard deviations of the size's prior
constexpr double one_edge_roughness = 1.5;  // times the residuals of frame 0

double mean_of(const std::vector<double>& line, int first, int last) {
    return std::accumulate(line.begin() + first, line.begin() + last, 0.0) / (last - first);
}

// Score of two edges of the right polarity at centre -+ size; 1 for the contrast of frame 0.
double RectangleLocator::pair_score(double centre) const {
    const int left = static_cast<int>(std::lround(centre - learned_.size));
    const int right = static_cast<int>(std::lround(centre + learned_.size));
    if (left < plateau || right + plateau >= static_cast<int>(profile_.size())) return 0;
    const auto step = [&](int inside0, int outside0) {
        return sign_ *
               (mean_of(profile_, inside0, inside0 + plateau) -
                mean_of(profile_, outside0, outside0 + plateau)) /
               contrast_;
    };
    const double a = step(left + 1, left - plateau), b = step(right - plateau, right + 1);
    return std::min({a, b, 1.0});
}

// A target that comes nearer grows little from picture to picture. Where the edges are farther apart or
// nearer at once, one of them belongs to something in front, and the place is wrong by up to the change of
// the size.
void RectangleLocator::doubt_size(double size, Candidate& out) const {
    const double change = size - size_;
    if (std::abs(change) < sizes_off * prior_.size) return;
    out.degraded = true;
    out.sd = std::hypot(out.sd, change);
}

void RectangleLocator::find_edges(const Box& box, double given) {
    const int first = axis_ == Axis::x ? box.x0 : box.y0, last = axis_ == Axis::x ? box.x1 : box.y1;
    const auto [low, high] = std::minmax_element(profile_.begin() + first, profile_.begin() + last);
    const double middle = 0.5 * (*low + *high);
    contrast_ = *high - *low;
    if (given > 0) {
        // The told width may be wrong by a little; an edge is found within the plateaus beside it.
        const int steps = static_cast<int>(std::ceil(wrong_size * 0.5 * given / width_step));
        Outline found;
        double best = 0.25;
        for (int k = 0; k <= 2 * steps; ++k) {
            learned_.size = 0.5 * given + (k % 2 == 0 ? -1 : 1) * width_step * ((k + 1) / 2);
            for (int c = 2 * first; c < 2 * last; ++c) {
                const double score = pair_score(0.5 * c);
                if (score > best) best = score, found = learned_, found.x = 0.5 * c;
            }
        }
        learned_ = found;
        if (best > 0.25) return;
    } else {
        int run = 0, longest = 0;
        for (int i = first; i < last; ++i) {
            const bool inside = sign_ * (profile_[static_cast<std::size_t>(i)] - middle) > 0;
            run = inside ? run + 1 : 0;
            if (run > longest) {
                longest = run;
                learned_.x = i - 0.5 * (run - 1);
            }
        }
        learned_.size = 0.5 * longest;
        if (longest >= 6) return;
    }
    throw InputError{fmt::format(
        "{}: found no two edges of a {} rectangle{}; check the region, polarity and width_mm", subject_.label,
        sign_ > 0 ? "bright" : "dark", given > 0 ? fmt::format(" {:.4g} px wide", given) : "")};
}

// The rows that show both edges, without a few at the silhouette's top and bottom if those are in the image.
void RectangleLocator::find_rows(const ImageView& image, int first, int last, double centre) {
    const int left = static_cast<int>(std::lround(centre - learned_.size));
    const int right = static_cast<int>(std::lround(centre + learned_.size));
    const int end = length_along(image, axis_);
    line_.resize(plateau);
    const auto level = [&](int at, int row) {
        mean_profile(image, axis_, std::clamp(at, 0, end - plateau), row, row + 1, line_);
        return mean_of(line_, 0, plateau);
    };
    std::vector<double> contrast;
    for (int row = first; row < last; ++row) {
        const double a = level(left + 2, row) - level(left - plateau - 1, row);
        const double b = level(right - plateau - 1, row) - level(right + 2, row);
        contrast.push_back(std::min(sign_ * a, sign_ * b));
    }
    const double enough = 0.6 * *std::max_element(contrast.begin(), contrast.end());
    int best = 0, run = 0, stop = first;
    for (int row = first; row < last; ++row) {
        run = contrast[static_cast<std::size_t>(row - first)] > enough ? run + 1 : 0;
        if (run > best) best = run, stop = row + 1;
    }
    constexpr int rounding = 3;
    row0_ = stop - best, row1_ = stop;
    if (row0_ > 0 && best > 4 * rounding) row0_ += rounding;
    if (row1_ < length_across(image, axis_) && best > 4 * rounding) row1_ -= rounding;
}

Point RectangleLocator::learn(const ImageView& image) {
    const Box box = region_in(subject_, image);
    const Levels levels = levels_in(subject_, image, box);
    const int across0 = axis_ == Axis::x ? box.y0 : box.x0, across1 = axis_ == Axis::x ? box.y1 : box.x1;
    row0_ = across0, row1_ = across1;
    load_profile(image);
    find_edges(box, crossing_px(subject_, subject_.target.width_mm));
    find_rows(image, across0, across1, learned_.x);
    expect(learned_);
    const Point start{learned_.x, 0};
    const double expected = size_;
    prior_ = {.y = 0, .size = 0.5 + 0.05 * expected, .blur = 1.0, .sign = sign_, .reach = reach_of_edge};
    const EdgeFitResult fit = measure(image, start, prior_);
    const bool good = fit.converged && fit.trimmed < 0.3 && fit.noise < 0.5 * std::abs(fit.contrast) &&
                      sign_ * fit.contrast > 0.2 * (levels.high - levels.low) &&
                      std::abs(fit.outline.x - start.x) < 6 &&
                      std::abs(fit.outline.size / expected - 1) < 0.15;
    if (!good) {
        throw InputError{fmt::format("{}: the two edges found, {:.4g} px apart, do not fit a rectangle",
                                     subject_.label, 2 * expected)};
    }
    const auto size = static_cast<double>(std::lround(fit.outline.size));
    std::vector<Point> shifts;
    for (int g = 0; g <= group_count(); ++g)
        shifts.insert(shifts.end(), {Point{size, 0}, Point{strip_side - size, 0}});
    strip_.resize(shifts.size() * strip_side);
    begin(fit, levels, shifts, 2);
    return place(learned_.x);
}

double RectangleLocator::rim() const noexcept { return window; }

// The strip shows both edges side by side, without what is between them.
RectangleLocator::Sites RectangleLocator::sites() const {
    Sites all;
    for (int g = 0; g <= group_count(); ++g)  // the last one: their mean
        for (int side = 0; side < 2; ++side)
            for (int i = -window; i <= window; ++i) all.push_back({i + side * strip_side, g, 2 * g + side});
    return all;
}

// False when an edge is too near to the picture's, or outside.
bool RectangleLocator::look(const ImageView& image, Point at) {
    const auto middle = static_cast<int>(std::lround(at.x)),
               size = static_cast<int>(std::lround(learned_.size));
    const int left = middle - size - strip_half, right = middle + size - strip_half;
    constexpr int bytes = sizeof(float);
    seen_ = {.pixels = reinterpret_cast<const std::byte*>(strip_.data()),
             .width = 2 * strip_side,
             .height = group_count() + 1,
             .stride = 2 * strip_side * bytes,
             .bytes_per_pixel = bytes};
    origin_ = {static_cast<double>(middle - strip_half), 0};
    if (left < 0 || right + strip_side > length_along(image, axis_) || left + strip_side > right) {
        std::ranges::fill(strip_, 0.0f);
        return false;
    }
    const int rows = row1_ - row0_, count = group_count();
    line_.resize(strip_side);
    float *to = strip_.data(), *const mean = to + 2 * strip_side * count;
    std::fill_n(mean, 2 * strip_side, 0.0f);
    for (int g = 0; g < count; ++g) {
        for (const int first : {left, right}) {
            mean_profile(image, axis_, first, row0_ + rows * g / count, row0_ + rows * (g + 1) / count,
                         line_);
            to = std::transform(line_.begin(), line_.end(), to,
                                [](double v) { return static_cast<float>(v); });
        }
        for (int i = 0; i < 2 * strip_side; ++i)
            mean[i] += to[i - 2 * strip_side] / static_cast<float>(count);
    }
    return true;
}

Point RectangleLocator::place(double along) const noexcept {
    const double across = 0.5 * (row0_ + row1_ - 1);
    return axis_ == Axis::x ? Point{along, across} : Point{across, along};
}

void RectangleLocator::gather(const ImageView& image, Point centre, int) {
    auto& samples = fit_.samples();
    samples.clear();
    const int end = length_along(image, axis_), rows = row1_ - row0_, count = group_count();
    line_.resize(2 * window + 1);
    for (int side = 0; side < 2; ++side) {
        const double edge = centre.x + (side == 0 ? -learned_.size : learned_.size);
        const int middle = static_cast<int>(std::lround(edge));
        const int first = std::max(0, middle - window), last = std::min(end - 1, middle + window);
        if (last - first < window) continue;
        const std::span<double> line{line_.data(), static_cast<std::size_t>(last - first + 1)};
        for (int g = 0; g < count; ++g) {
            mean_profile(image, axis_, first, row0_ + rows * g / count, row0_ + rows * (g + 1) / count, line);
            for (std::size_t i = 0; i < line.size(); ++i) {
                const double u = first + static_cast<double>(i);
                // Pixels beyond the middle belong to the other edge.
                if ((side == 0) == (u < centre.x)) samples.push_back({u, 0, line[i], 2 * g + side});
            }
        }
    }
}

bool RectangleLocator::locate(const ImageView& image, Point predicted, Candidate& out) {
    const Point at{axis_ == Axis::x ? predicted.x : predicted.y, 0};
    if (!OutlineLocator::locate(image, at, out)) return false;
    out.at = place(out.at.x);
    return true;
}

// First of the old size; if that does not fit, of a size that both edges may change: they move apart when the
// bright side is clipped or the target grows.
EdgeFitResult RectangleLocator::fit_near(const ImageView& image, Point at, Candidate& out) {
    EdgeFitResult fit = measure(image, at, prior_);
    if (!is_target(fit, out) || out.degraded || rougher(fit, one_edge_roughness)) {
        EdgePrior wide = prior_;
        wide.size = 1 + wide_share * learned_.size;
        const EdgeFitResult free = measure(image, at, wide);
        if (free.converged && (!fit.converged || free.trimmed < fit.trimmed)) fit = free;
        fit.converged = is_target(fit, out);
    }
    if (fit.converged) doubt_size(fit.outline.size, out);
    return fit;
}

bool RectangleLocator::find_near(const ImageView& image, Point predicted, Candidate& out) {
    if (try_at(image, predicted, predicted, out)) return true;
    load_profile(image);
    double best = 0.3, at = predicted.x;
    for (int i = 0; i <= 2 * static_cast<int>(reach()); ++i) {
        const double c = predicted.x - reach() + i, score = pair_score(c);
        if (score > best) best = score, at = c;
    }
    return best > 0.3 && try_at(image, {at, 0}, predicted, out);
}

void RectangleLocator::search(const ImageView& image, Point, Sweep, std::vector<Candidate>& out) {
    fit_.forget();
    load_profile(image);
    double before = 0, here = pair_score(0);
    for (int c = 0; c < std::ssize(profile_); ++c) {
        const double after = pair_score(c + 1);
        Candidate candidate;
        const bool peak = here > 0.3 && here >= before && here > after;
        if (peak && fit_near(image, {static_cast<double>(c), 0}, candidate).converged) {
            candidate.at = place(candidate.at.x);
            const auto same = [&](const Candidate& o) { return length(o.at - candidate.at) < extent(); };
            if (std::ranges::none_of(out, same)) out.push_back(candidate);
        }
        before = std::exchange(here, after);
    }
    std::ranges::stable_sort(out, std::greater{}, &Candidate::likeness);
}

}  // namespace

std::unique_ptr<Locator> make_rectangle_locator(Subject subject) {
    return std::make_unique<RectangleLocator>(std::move(subject));
}

}  // namespace shaker::tracking
