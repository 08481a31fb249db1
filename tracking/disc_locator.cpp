// Locator for a disc or a single dot: fit of its rim.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tracking/round_locator.hpp"

namespace shaker::tracking {

namespace {

constexpr double reach_of_rim = 5.5;  // px at which pixels have faded out, wherever the centre is in its own
constexpr double least_rim_seen = 0.15;  // mean over the rim, below which a fit would find nothing
constexpr double most_rim_misfit = 0.3;  // share of the rim in the region, in frame 0
constexpr double size_step = 3;          // px of radius

/// Large discs are divided into sectors with their own gain and offset, so that hidden or reflecting parts of
/// the rim can be excluded; small ones are one block on a plane of background. The diameter is measured when
/// it is not given, or is wrong by up to 4 %.
class DiscLocator final : public RoundLocator {
public:
    explicit DiscLocator(Subject subject) : RoundLocator{std::move(subject)} {}
    Point learn(const ImageView& image) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 10; }
    [[nodiscard]] bool interchangeable() const noexcept override { return true; }

private:
    [[nodiscard]] bool plane() const noexcept override { return learned_.size < 16; }
    [[nodiscard]] double rim() const noexcept override { return plane() ? 4.5 : 6.25; }
    bool look(const ImageView& image, Point at) override;
    bool find_near(const ImageView& image, Point predicted, Candidate& out) override;
    bool find(const ImageView& image, const Box& box, double size, double contrast, EdgeFitResult& fit);
    double misfit_in(const ImageView& image, const Box& box, const EdgeFitResult& whole);
    double radius_by_threshold(const ImageView& image, const Box& box, const Levels& levels) const;
    void try_peaks(const ImageView& image, Sweep sweep, std::vector<Candidate>& out);
    [[nodiscard]] Box around(Point at) const noexcept;
    [[nodiscard]] bool inside(const ImageView& image, Point at) const noexcept;

    bool rim_seen_ = false;
    // Progress of a search that takes several pictures.
    std::size_t tries_ = 2, turn_ = 0;
    int next_row_ = std::numeric_limits<int>::max();
};

double DiscLocator::radius_by_threshold(const ImageView& image, const Box& box, const Levels& levels) const {
    const double middle = 0.5 * (levels.low + levels.high);
    cv::Mat1b mask(box.y1 - box.y0, box.x1 - box.x0);
    with_pixels(image, [&](auto pixels) {
        for (int y = box.y0; y < box.y1; ++y) {
            for (int x = box.x0; x < box.x1; ++x) {
                mask(y - box.y0, x - box.x0) = sign_ * (pixels.at(x, y) - middle) > 0 ? 1 : 0;
            }
        }
    });
    cv::Mat labels, stats, centres;
    const int count = cv::connectedComponentsWithStats(mask, labels, stats, centres, 8, CV_32S);
    int best = 0;
    for (int i = 1; i < count; ++i) {
        const bool larger =
            best == 0 || stats.at<int>(i, cv::CC_STAT_AREA) > stats.at<int>(best, cv::CC_STAT_AREA);
        const double w = stats.at<int>(i, cv::CC_STAT_WIDTH), h = stats.at<int>(i, cv::CC_STAT_HEIGHT);
        if (larger && std::max(w, h) < 1.3 * std::min(w, h)) best = i;
    }
    if (best == 0)
        throw InputError{
            subject_.label +
            ": found no round shape of this polarity; check the region and polarity; a disc that is "
            "cut by the edge of the picture needs diameter_mm"};
    return std::sqrt(stats.at<int>(best, cv::CC_STAT_AREA) / std::numbers::pi);
}

Point DiscLocator::learn(const ImageView& image) {
    const Box box = region_in(subject_, image);
    const Levels levels = levels_in(subject_, image, box);
    const double given = 0.5 * subject_.target.diameter_mm / subject_.mm_per_px;
    const double expected = given > 0 ? given : radius_by_threshold(image, box, levels);
    if (expected < 1.5) {
        throw InputError{
            fmt::format("{}: diameter is {:.4g} px; must be at least 3 px", subject_.label, 2 * expected)};
    }
    // A fit reaches sizes that are wrong by less than the rim's width.
    const int steps = given > 0 ? static_cast<int>(wrong_size * given / size_step) : 0;
    for (int k = 0; k <= 2 * steps; ++k) {
        const double size = expected + (k % 2 == 0 ? -1 : 1) * size_step * std::ceil(0.5 * k);
        EdgeFitResult fit;
        if (!find(image, box, size, levels.high - levels.low, fit)) continue;
        begin(fit, levels, std::vector<Point>(static_cast<std::size_t>(blocks_)));
        ring_ = RingSearch{size_, blur_, sign_};
        tries_ = std::max<std::size_t>(2, 2 * searched_pixels / fit_.samples().size());
        return place_of(fit);
    }
    throw not_found("disc", expected);
}

// A disc of about this radius with its centre in the region.
bool DiscLocator::find(const ImageView& image, const Box& box, double size, double contrast,
                       EdgeFitResult& fit) {
    expect({0, 0, size, 1});
    blocks_ = plane() ? 1 : std::clamp(static_cast<int>(size / 2), 8, 64);
    prior_ = {.size = 0.5 + 0.1 * size, .blur = 1.0, .sign = sign_, .reach = reach_of_rim};
    ring_ = RingSearch{size, 1, sign_};
    ring_.scan(image, box, contrast, 0.25, peaks_);
    return std::ranges::any_of(peaks_, [&](const RingPeak& peak) {
        fit = measure_peak(image, peak, contrast, 0.5);
        const auto [x, y] = place_of(fit);
        return fit.converged &&
               box.contains(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))) &&
               (fit.trimmed < most_rim_misfit || misfit_in(image, box, fit) < most_rim_misfit);
    });
}

// Share of the rim in the region that does not fit: what lies outside of it is not the user's target.
double DiscLocator::misfit_in(const ImageView& image, const Box& box, const EdgeFitResult& whole) {
    gather(image, place_of(whole), 1);
    std::erase_if(fit_.samples(), [&](const EdgeSample& s) {
        return !box.contains(static_cast<int>(s.u), static_cast<int>(s.v));
    });
    const EdgeFitResult fit = fit_.fit(whole.outline, prior_, blocks_, ground());
    return fit.converged ? fit.trimmed : 1;
}

bool DiscLocator::inside(const ImageView& image, Point at) const noexcept {
    const double margin = 0.7 * size_;
    return at.x > -margin && at.y > -margin && at.x < image.width - 1 + margin &&
           at.y < image.height - 1 + margin;
}

Box DiscLocator::around(Point at) const noexcept {
    const int x = static_cast<int>(std::lround(at.x)), y = static_cast<int>(std::lround(at.y));
    const int r = static_cast<int>(reach());
    return {x - r, y - r, x + r + 1, y + r + 1};
}

bool DiscLocator::look(const ImageView& image, Point at) {
    seen_ = image;
    rim_seen_ = inside(image, at) &&
                ring_.score(image, static_cast<int>(std::lround(at.x)), static_cast<int>(std::lround(at.y)),
                            0.35 * contrast_) > least_rim_seen;
    return rim_seen_;
}

bool DiscLocator::find_near(const ImageView& image, Point predicted, Candidate& out) {
    if (!inside(image, predicted)) return false;
    if (rim_seen_ && try_at(image, start(), predicted, out)) return true;
    ring_.scan(image, around(predicted), 0.5 * contrast_, 0.5, peaks_);
    return !peaks_.empty() &&
           try_at(image, ring_.refine(image, peaks_.front().at, 0.5 * contrast_), predicted, out);
}

// Candidates among the peaks of a scan. A share tries the best peak, and the others in turn.
void DiscLocator::try_peaks(const ImageView& image, Sweep sweep, std::vector<Candidate>& out) {
    const std::size_t all = peaks_.size(), tries = sweep == Sweep::whole ? all : std::min(all, tries_);
    for (std::size_t i = 0; i < tries; ++i) {
        const std::size_t k = i == 0 || tries == all ? i : 1 + turn_++ % (all - 1);
        const Point start = ring_.refine(image, peaks_[k].at, contrast_);
        Candidate candidate;
        if (!is_target(measure(image, start, prior_, coarse, search_every_), candidate)) continue;
        const auto same = [&](const Candidate& c) { return length(c.at - candidate.at) < extent(); };
        if (std::none_of(out.begin(), out.end(), same)) out.push_back(candidate);
    }
}

void DiscLocator::search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) {
    fit_.forget();
    const int margin = static_cast<int>(0.7 * learned_.size);
    Box box{-margin, -margin, image.width + margin, image.height + margin};
    const int rows = ring_.rows_at_a_time(box.x1 - box.x0);
    // Half the contrast all around the rim, rather than the full contrast on half of it.
    const auto scan = [&](const Box& part) {
        ring_.scan(image, part, 0.5 * contrast_, 0.6, peaks_);
        try_peaks(image, sweep, out);
    };
    if (sweep == Sweep::share && rows < box.y1 - box.y0) {
        scan(around(last));
        if (next_row_ >= box.y1) next_row_ = box.y0;
        box.y0 = std::max(box.y0, next_row_);
        box.y1 = next_row_ = std::min(box.y1, box.y0 + rows);
    }
    if (out.empty()) scan(box);
    std::stable_sort(out.begin(), out.end(), [](auto& a, auto& b) { return a.likeness > b.likeness; });
}

}  // namespace

std::unique_ptr<Locator> make_disc_locator(Subject subject) {
    return std::make_unique<DiscLocator>(std::move(subject));
}

}  // namespace shaker::tracking
