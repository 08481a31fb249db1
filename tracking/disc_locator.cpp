// Locator for a disc or a single dot: fit of its rim.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tracking/image/edge_fit.hpp"
#include "tracking/image/region.hpp"
#include "tracking/image/ring_search.hpp"
#include "tracking/locator.hpp"
#include "tracking/outline_follower.hpp"

namespace shaker::tracking {

namespace {

/// Large discs are divided into sectors with their own gain and offset, so that hidden or reflecting parts of
/// the rim can be excluded; small ones are one block on a plane of background. The diameter is measured when
/// it is not given, or is wrong by up to 4 %.
class DiscLocator final : public Locator {
public:
    explicit DiscLocator(Subject subject);
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 10; }
    [[nodiscard]] double extent() const noexcept override { return learned_.size; }
    [[nodiscard]] std::optional<Correction> correction() const override {
        return correction_of("diameter_mm", subject_.target.diameter_mm,
                             subject_.target.diameter_mm / subject_.mm_per_px, disc_diameter(learned_));
    }
    [[nodiscard]] bool interchangeable() const noexcept override { return true; }

private:
    void watch(const ImageView& image, const EdgeFitResult& fit);
    bool is_target(const EdgeFitResult& fit, Candidate& out) const;
    [[nodiscard]] bool small() const noexcept { return learned_.size < 16; }
    // px on either side of the edge that are read
    [[nodiscard]] double rim() const noexcept { return small() ? 4.5 : 6.25; }
    bool find(const ImageView& image, const Box& box, double size, double contrast, EdgeFitResult& fit);
    double misfit_in(const ImageView& image, const Box& box, const EdgeFitResult& whole);
    // every: takes one of so many pixels.
    void gather(const ImageView& image, Point centre, int every);
    [[nodiscard]] OutlineFollower::Sites sites() const;
    [[nodiscard]] int block_of(double dx, double dy) const noexcept;
    EdgeFitResult measure(const ImageView& image, Point start, double enough = 3e-3, int every = 1);
    double radius_by_threshold(const ImageView& image, const Box& box, const Levels& levels) const;
    void try_peaks(const ImageView& image, Sweep sweep, std::vector<Candidate>& out);
    [[nodiscard]] Box around(Point at) const noexcept;
    [[nodiscard]] bool inside(const ImageView& image, Point at) const noexcept;

    Subject subject_;
    double sign_;
    EdgeFit fit_;
    OutlineFollower follower_;
    RingSearch ring_;
    std::vector<RingPeak> peaks_;
    Outline learned_;
    EdgePrior prior_;
    OutlineReference reference_;
    double contrast_ = 0, blur_ = 1;
    int blocks_ = 1;
    // Progress of a search that takes several pictures.
    std::size_t tries_ = 2, turn_ = 0;
    int search_every_ = 1, watch_every_ = 1;
    int next_row_ = std::numeric_limits<int>::max();
};

constexpr double reach_of_rim = 5.5;  // px at which pixels have faded out, wherever the centre is in its own
constexpr double least_rim_seen = 0.15;  // mean over the rim, below which a fit would find nothing
constexpr double most_rim_misfit = 0.3;  // share of the rim in the region, in frame 0
constexpr double size_step = 3;          // px of radius
constexpr int searched_pixels = 1500;    // of the rim, with which a peak of a search is tried
constexpr int watched_pixels = 500;      // with which the careful fit watches the filters

// Monotone in the angle, without an arc tangent: 0..4 for one turn.
double diamond_angle(double dx, double dy) noexcept {
    const double sum = std::abs(dx) + std::abs(dy);
    if (!(sum > 0)) return 0;
    const double t = dy / sum;
    return dx >= 0 ? (dy >= 0 ? t : 4 + t) : 2 - t;
}

DiscLocator::DiscLocator(Subject subject)
    : subject_{std::move(subject)},
      sign_{subject_.target.polarity == Polarity::bright ? 1.0 : -1.0},
      ring_{4, 1, sign_} {}

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
        learned_ = fit.outline;
        blur_ = learned_.blur;
        contrast_ = std::abs(fit.contrast);
        reference_ = {learned_, sign_, contrast_, fit.coverage, fit.noise, fit.trimmed, fit.slope};
        prior_ = {.size = 0.02, .blur = 0.5, .sign = sign_, .reach = reach_of_rim};
        ring_ = RingSearch{learned_.size, learned_.blur, sign_};
        follower_.begin({.size = learned_.size,
                         .blur = learned_.blur,
                         .size_sd = prior_.size,
                         .ground = small() ? EdgeFit::Ground::plane : EdgeFit::Ground::flat,
                         .reach = reach_of_rim,
                         .level = 0.5 * (levels.low + levels.high)},
                        sites(), std::vector<Point>(static_cast<std::size_t>(blocks_)));
        const int pixels = static_cast<int>(fit_.samples().size());
        search_every_ = (pixels + searched_pixels - 1) / searched_pixels;
        watch_every_ = (pixels + watched_pixels - 1) / watched_pixels;
        tries_ = static_cast<std::size_t>(std::max(2, 2 * searched_pixels / pixels));
        return {learned_.x, learned_.y};
    }
    throw InputError{
        fmt::format("{}: found no {} disc of {:.4g} px diameter; check the region, polarity and diameter_mm",
                    subject_.label, sign_ > 0 ? "bright" : "dark", 2 * expected)};
}

// A disc of about this radius with its centre in the region.
bool DiscLocator::find(const ImageView& image, const Box& box, double size, double contrast,
                       EdgeFitResult& fit) {
    learned_ = {0, 0, size, 1};
    blur_ = 1;
    blocks_ = small() ? 1 : std::clamp(static_cast<int>(size / 2), 8, 64);
    prior_ = {.size = 0.5 + 0.1 * size, .blur = 1.0, .sign = sign_, .reach = reach_of_rim};
    ring_ = RingSearch{size, 1, sign_};
    ring_.scan(image, box, contrast, 0.25, peaks_);
    return std::ranges::any_of(peaks_, [&](const RingPeak& peak) {
        const Point start = ring_.refine(image, peak.at, contrast);
        fit = measure(image, start);
        const Point at{fit.outline.x, fit.outline.y};
        return fit.converged && sign_ * fit.contrast > 0.25 * contrast &&
               fit.noise < 0.5 * std::abs(fit.contrast) &&
               (fit.trimmed < most_rim_misfit || misfit_in(image, box, fit) < most_rim_misfit) &&
               std::abs(fit.outline.size / size - 1) < 0.2 && length(at - start) < 6 &&
               box.contains(static_cast<int>(std::lround(at.x)), static_cast<int>(std::lround(at.y)));
    });
}

// Share of the rim in the region that does not fit: what lies outside of it is not the user's target.
double DiscLocator::misfit_in(const ImageView& image, const Box& box, const EdgeFitResult& whole) {
    gather(image, {whole.outline.x, whole.outline.y}, 1);
    std::erase_if(fit_.samples(), [&](const EdgeSample& s) {
        return !box.contains(static_cast<int>(s.u), static_cast<int>(s.v));
    });
    const EdgeFitResult fit =
        fit_.fit(whole.outline, prior_, blocks_, small() ? EdgeFit::Ground::plane : EdgeFit::Ground::flat);
    return fit.converged ? fit.trimmed : 1;
}

int DiscLocator::block_of(double dx, double dy) const noexcept {
    return std::min(static_cast<int>(0.25 * blocks_ * diamond_angle(dx, dy)), blocks_ - 1);
}

OutlineFollower::Sites DiscLocator::sites() const {
    OutlineFollower::Sites all;
    const double outer = learned_.size + rim(), inner = small() ? 0 : learned_.size - rim();
    const int reach = static_cast<int>(std::ceil(outer));
    for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
            const double r = std::hypot(x, y);
            if (r >= inner && r <= outer) all.push_back({x, y, block_of(x, y)});
        }
    }
    std::ranges::stable_sort(all, {}, &OutlineBank::Site::block);
    return all;
}

void DiscLocator::gather(const ImageView& image, Point centre, int every) {
    auto& samples = fit_.samples();
    samples.clear();
    const double outer = learned_.size + rim(), inner = small() ? 0 : learned_.size - rim();
    const int y0 = std::max(0, static_cast<int>(std::ceil(centre.y - outer)));
    const int y1 = std::min(image.height - 1, static_cast<int>(std::floor(centre.y + outer)));
    with_pixels(image, [&](auto pixels) {
        for (int y = y0; y <= y1; ++y) {
            const auto* row = pixels.row(y);
            const double dy = y - centre.y;
            const double half = std::sqrt(std::max(0.0, outer * outer - dy * dy));
            const double hole = std::sqrt(std::max(0.0, inner * inner - dy * dy));
            const int x0 = std::max(0, static_cast<int>(std::ceil(centre.x - half)));
            const int x1 = std::min(image.width - 1, static_cast<int>(std::floor(centre.x + half)));
            for (int x = x0 + y % every; x <= x1; x += every) {
                const double dx = x - centre.x;
                if (std::abs(dx) < hole) {
                    const int inside = static_cast<int>(std::floor(centre.x + hole)) - x;
                    x += inside / every * every;
                    continue;
                }
                samples.push_back({double(x), double(y), static_cast<double>(row[x]), block_of(dx, dy)});
            }
        }
    });
}

EdgeFitResult DiscLocator::measure(const ImageView& image, Point start, double enough, int every) {
    Point centre = start;
    for (const int passes : {5, 6, 14}) {
        gather(image, centre, every);
        if (fit_.samples().size() < 24) return {};
        EdgeFitResult fit =
            fit_.fit({centre.x, centre.y, learned_.size, blur_}, prior_, blocks_,
                     small() ? EdgeFit::Ground::plane : EdgeFit::Ground::flat, passes, enough);
        const Point found{fit.outline.x, fit.outline.y};
        const double moved = length(found - centre);
        fit.coverage *= every;
        if (fit.converged && moved < 1) return fit;
        if (!(moved < 2 * rim()) || !(fit.noise < prior_.roughest * sign_ * fit.contrast)) return {};
        centre = found;
    }
    return {};
}

bool DiscLocator::inside(const ImageView& image, Point at) const noexcept {
    const double margin = 0.7 * learned_.size;
    return at.x > -margin && at.y > -margin && at.x < image.width - 1 + margin &&
           at.y < image.height - 1 + margin;
}

Box DiscLocator::around(Point at) const noexcept {
    const int x = static_cast<int>(std::lround(at.x)), y = static_cast<int>(std::lround(at.y));
    const int r = static_cast<int>(reach());
    return {x - r, y - r, x + r + 1, y + r + 1};
}

bool DiscLocator::locate(const ImageView& image, Point predicted, Candidate& out) {
    if (!inside(image, predicted)) return false;
    const double rim_seen = ring_.score(image, static_cast<int>(std::lround(predicted.x)),
                                        static_cast<int>(std::lround(predicted.y)), 0.35 * contrast_);
    EdgeFitResult fit;
    if (rim_seen > least_rim_seen) {
        if (follower_.follow(image, predicted, reference_, subject_.along, fit_.slopes(), out)) {
            if (follower_.due()) watch(image, measure(image, out.at, 0.1, watch_every_));
            return true;
        }
        fit = measure(image, follower_.start());
    } else {
        follower_.pass_over();
    }
    const auto accept = [&] { return is_target(fit, out) && length(out.at - predicted) <= reach() + rim(); };
    bool good = accept();
    if (!good) {
        ring_.scan(image, around(predicted), 0.5 * contrast_, 0.5, peaks_);
        if (!peaks_.empty()) {
            fit = measure(image, ring_.refine(image, peaks_.front().at, 0.5 * contrast_));
            good = accept();
        }
    }
    if (!good) return false;
    fit_.accept();
    watch(image, fit);
    return true;
}

void DiscLocator::watch(const ImageView& image, const EdgeFitResult& fit) {
    if (fit.converged) blur_ = followed_blur(blur_, fit.outline.blur);
    follower_.watch(image, fit, subject_.along, learned_.size, blur_, fit_.slopes());
}

// A small disc has no blocks that could disagree: what cuts it shows in the residuals only.
bool DiscLocator::is_target(const EdgeFitResult& fit, Candidate& out) const {
    if (!judge(fit, reference_, subject_.along, out)) return false;
    out.degraded = out.degraded || (small() && rougher(fit, reference_, cut_roughness));
    return true;
}

// Candidates among the peaks of a scan. A share tries the best peak, and the others in turn.
void DiscLocator::try_peaks(const ImageView& image, Sweep sweep, std::vector<Candidate>& out) {
    const std::size_t all = peaks_.size(), tries = sweep == Sweep::whole ? all : std::min(all, tries_);
    for (std::size_t i = 0; i < tries; ++i) {
        const std::size_t k = i == 0 || tries == all ? i : 1 + turn_++ % (all - 1);
        const Point start = ring_.refine(image, peaks_[k].at, contrast_);
        Candidate candidate;
        if (!is_target(measure(image, start, 0.1, search_every_), candidate)) continue;
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
