// Locator for several dots of one pitch that move as one rigid body.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "tracking/image/edge_fit.hpp"
#include "tracking/image/region.hpp"
#include "tracking/image/ring_search.hpp"
#include "tracking/locator.hpp"
#include "tracking/outline_follower.hpp"

namespace shaker::tracking {

namespace {

/// The position is the mean of the dots that were in the region in frame 0; it does not change when some of
/// them leave the view. The row is periodic: after a loss the search covers half a pitch around the last
/// position.
class DotsLocator final : public Locator {
public:
    explicit DotsLocator(Subject subject);
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 0.4 * pitch_; }
    [[nodiscard]] double extent() const noexcept override { return 0.5 * pitch_; }
    [[nodiscard]] double pitch() const noexcept override { return pitch_; }
    [[nodiscard]] std::optional<Correction> correction() const override {
        return correction_of("diameter_mm", subject_.target.diameter_mm,
                             subject_.target.diameter_mm / subject_.mm_per_px, disc_diameter(learned_));
    }
    [[nodiscard]] bool interchangeable() const noexcept override { return false; }

private:
    void gather(const ImageView& image, Point centre);
    [[nodiscard]] OutlineFollower::Sites sites() const;
    void find_dots(const ImageView& image, const Box& box, double contrast);
    void check_pitch() const;
    EdgeFitResult measure(const ImageView& image, Point start);
    void watch(const ImageView& image, const EdgeFitResult& fit);

    Subject subject_;
    double sign_, pitch_;
    EdgeFit fit_;
    OutlineFollower follower_;
    RingSearch ring_;
    std::vector<Point> offsets_;
    Outline learned_;
    EdgePrior prior_;
    OutlineReference reference_;
    double blur_ = 1;
};

constexpr double rim_of_dot = 3;  // px around a dot that are fitted; there is little space between dots

DotsLocator::DotsLocator(Subject subject)
    : subject_{std::move(subject)},
      sign_{subject_.target.polarity == Polarity::bright ? 1.0 : -1.0},
      pitch_{subject_.target.pitch_mm / subject_.mm_per_px},
      ring_{0.5 * subject_.target.diameter_mm / subject_.mm_per_px, 1, sign_} {
    learned_ = {0, 0, 0.5 * subject_.target.diameter_mm / subject_.mm_per_px, 1};
    if (!(learned_.size >= 1.5)) {
        throw InputError{
            fmt::format("{}: diameter_mm = {}; dots with a pitch require a diameter of at least 3 px",
                        subject_.label, subject_.target.diameter_mm)};
    }
    if (!(pitch_ > 2 * learned_.size)) {
        throw InputError{fmt::format("{}: pitch_mm = {}; must exceed the dots' diameter", subject_.label,
                                     subject_.target.pitch_mm)};
    }
}

void DotsLocator::find_dots(const ImageView& image, const Box& box, double contrast) {
    std::vector<RingPeak> peaks;
    ring_.scan(image, box, contrast, 0.35, peaks);
    std::vector<EdgeFitResult> dots;
    const double expected = learned_.size;
    prior_ = {.size = 0.5 + 0.1 * expected, .blur = 1.0, .sign = sign_};
    offsets_ = {{0, 0}};
    for (const RingPeak& peak : peaks) {
        const Point start = ring_.refine(image, peak.at, contrast);
        const EdgeFitResult fit = measure(image, start);
        const Point at{fit.outline.x, fit.outline.y};
        const bool good = fit.converged && sign_ * fit.contrast > 0.25 * contrast && fit.trimmed < 0.3 &&
                          fit.noise < 0.3 * std::abs(fit.contrast) && length(at - start) < 3 &&
                          std::abs(fit.outline.size / expected - 1) < 0.2;
        const auto same = [&](const EdgeFitResult& o) {
            return length(at - Point{o.outline.x, o.outline.y}) < 0.5 * pitch_;
        };
        if (good && std::none_of(dots.begin(), dots.end(), same)) dots.push_back(fit);
    }
    if (dots.empty()) {
        throw InputError{fmt::format(
            "{}: found no {} dots of {:.4g} px diameter; check the region, polarity and diameter_mm",
            subject_.label, sign_ > 0 ? "bright" : "dark", 2 * expected)};
    }
    std::sort(dots.begin(), dots.end(), [](const EdgeFitResult& a, const EdgeFitResult& b) {
        return a.outline.x + a.outline.y < b.outline.x + b.outline.y;
    });
    learned_ = {};
    learned_.blur = 0;
    for (const EdgeFitResult& d : dots) {
        const double share = 1.0 / static_cast<double>(dots.size());
        learned_.x += share * d.outline.x;
        learned_.y += share * d.outline.y;
        learned_.size += share * d.outline.size;
        learned_.blur += share * d.outline.blur;
    }
    offsets_.clear();
    for (const EdgeFitResult& d : dots)
        offsets_.push_back({d.outline.x - learned_.x, d.outline.y - learned_.y});
}

void DotsLocator::check_pitch() const {
    if (offsets_.size() < 2) return;
    std::vector<double> gaps;
    for (const Point& a : offsets_) {
        double nearest = 1e9;
        for (const Point& b : offsets_) {
            if (&a != &b) nearest = std::min(nearest, length(a - b));
        }
        gaps.push_back(nearest);
    }
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
    const double gap = gaps[gaps.size() / 2];
    if (std::abs(gap / pitch_ - 1) > 0.2) {
        throw InputError{
            fmt::format("{}: the dots' distance is {:.4g} mm; pitch_mm = {} differs by more than 20 %",
                        subject_.label, gap * subject_.mm_per_px, subject_.target.pitch_mm)};
    }
}

Point DotsLocator::learn(const ImageView& image) {
    const Box box = region_in(subject_, image);
    const Levels levels = levels_in(subject_, image, box);
    find_dots(image, box, levels.high - levels.low);
    check_pitch();
    blur_ = learned_.blur;
    prior_ = {.size = 0.02, .blur = 0.5, .sign = sign_};
    ring_ = RingSearch{learned_.size, learned_.blur, sign_};
    const EdgeFitResult fit = measure(image, {learned_.x, learned_.y});
    if (!fit.converged) throw InputError{subject_.label + ": the dots found do not share one size and blur"};
    learned_ = fit.outline;
    reference_ = {learned_, sign_, std::abs(fit.contrast), fit.coverage, fit.noise, fit.trimmed, fit.slope};
    follower_.begin({.size = learned_.size,
                     .blur = learned_.blur,
                     .size_sd = prior_.size,
                     .ground = EdgeFit::Ground::plane,
                     .level = 0.5 * (levels.low + levels.high)},
                    sites(), offsets_);
    return {learned_.x, learned_.y};
}

OutlineFollower::Sites DotsLocator::sites() const {
    OutlineFollower::Sites all;
    const double outer = learned_.size + rim_of_dot;
    for (std::size_t k = 0; k < offsets_.size(); ++k) {
        const auto [dot_x, dot_y] = offsets_[k];
        for (int y = static_cast<int>(std::ceil(dot_y - outer)); y <= dot_y + outer; ++y)
            for (int x = static_cast<int>(std::ceil(dot_x - outer)); x <= dot_x + outer; ++x)
                if (std::hypot(x - dot_x, y - dot_y) <= outer) all.push_back({x, y, static_cast<int>(k)});
    }
    return all;
}

void DotsLocator::gather(const ImageView& image, Point centre) {
    auto& samples = fit_.samples();
    samples.clear();
    const double outer = learned_.size + rim_of_dot;
    for (std::size_t k = 0; k < offsets_.size(); ++k) {
        const Point dot = centre + offsets_[k];
        const int x0 = static_cast<int>(std::ceil(dot.x - outer)),
                  x1 = static_cast<int>(std::floor(dot.x + outer));
        const int y0 = static_cast<int>(std::ceil(dot.y - outer)),
                  y1 = static_cast<int>(std::floor(dot.y + outer));
        if (x0 < 0 || x1 >= image.width || y1 < 0 || y0 >= image.height) continue;
        with_pixels(image, [&](auto pixels) {
            for (int y = std::max(0, y0); y <= std::min(y1, image.height - 1); ++y) {
                const auto* row = pixels.row(y);
                for (int x = x0; x <= x1; ++x) {
                    const double dx = x - dot.x, dy = y - dot.y;
                    if (dx * dx + dy * dy > outer * outer) continue;
                    samples.push_back({x - offsets_[k].x, y - offsets_[k].y, static_cast<double>(row[x]),
                                       static_cast<int>(k)});
                }
            }
        });
    }
}

EdgeFitResult DotsLocator::measure(const ImageView& image, Point start) {
    Point centre = start;
    for (const int passes : {5, 6, 14}) {
        gather(image, centre);
        if (fit_.samples().size() < 24) return {};
        EdgeFitResult fit = fit_.fit({centre.x, centre.y, learned_.size, blur_}, prior_,
                                     static_cast<int>(offsets_.size()), EdgeFit::Ground::plane, passes);
        const Point found{fit.outline.x, fit.outline.y};
        const double moved = length(found - centre);
        if (fit.converged && moved < 1) return fit;
        if (!(moved < 2 * rim_of_dot) || !(fit.noise < prior_.roughest * sign_ * fit.contrast)) return {};
        centre = found;
    }
    return {};
}

bool DotsLocator::locate(const ImageView& image, Point predicted, Candidate& out) {
    if (follower_.follow(image, predicted, reference_, subject_.along, fit_.slopes(), out)) {
        if (follower_.due()) watch(image, measure(image, out.at));
        return true;
    }
    const EdgeFitResult fit = measure(image, follower_.start());
    if (!judge(fit, reference_, subject_.along, out) || length(out.at - predicted) > reach()) return false;
    out.degraded = out.degraded || rougher(fit, reference_, cut_roughness);
    fit_.accept();
    watch(image, fit);
    return true;
}

void DotsLocator::watch(const ImageView& image, const EdgeFitResult& fit) {
    if (fit.converged) blur_ = followed_blur(blur_, fit.outline.blur);
    follower_.watch(image, fit, subject_.along, learned_.size, blur_, fit_.slopes());
}

void DotsLocator::search(const ImageView& image, Point last, Sweep, std::vector<Candidate>& out) {
    fit_.forget();
    const int half = static_cast<int>(0.5 * pitch_);
    double best = 0.35 * static_cast<double>(offsets_.size());
    Point at;
    bool any = false;
    const auto look = [&](Point centre) {
        double sum = 0;
        for (const Point& offset : offsets_) {
            const Point dot = centre + offset;
            sum += ring_.score(image, static_cast<int>(std::lround(dot.x)),
                               static_cast<int>(std::lround(dot.y)), reference_.contrast);
        }
        if (sum > best) best = sum, at = centre, any = true;
    };
    for (int j = -half; j <= half; j += 2)
        for (int i = -half; i <= half; i += 2) look(last + Point{double(i), double(j)});
    for (const Point near : {Point{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        if (any) look(at + near);
    Candidate candidate;
    if (any && locate(image, at, candidate)) out.push_back(candidate);
}

}  // namespace

std::unique_ptr<Locator> make_dots_locator(Subject subject) {
    return std::make_unique<DotsLocator>(std::move(subject));
}

}  // namespace shaker::tracking
