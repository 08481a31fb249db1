// Locator for several dots of one pitch that move as one rigid body.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "tracking/round_locator.hpp"

namespace shaker::tracking {

namespace {

constexpr double rim_of_dot = 3;  // px around a dot that are fitted; there is little space between dots

/// Several dots of one pitch that move as one rigid body. The position is the mean of the dots that were in
/// the region in frame 0; it does not change when some of them leave the view. The row is periodic: after a
/// loss the search covers half a pitch around the last position.
class DotsLocator final : public RoundLocator {
public:
    explicit DotsLocator(Subject subject);
    Point learn(const ImageView& image) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 0.4 * pitch_; }
    [[nodiscard]] double extent() const noexcept override { return 0.5 * pitch_; }
    [[nodiscard]] double pitch() const noexcept override { return pitch_; }
    [[nodiscard]] bool interchangeable() const noexcept override { return false; }

private:
    [[nodiscard]] bool plane() const noexcept override { return true; }
    [[nodiscard]] double rim() const noexcept override { return rim_of_dot; }
    bool look(const ImageView& image, Point) override {
        seen_ = image;
        return true;
    }
    bool find_near(const ImageView& image, Point predicted, Candidate& out) override {
        return try_at(image, start(), predicted, out);
    }
    void find_dots(const ImageView& image, const Box& box, double contrast);
    void check_pitch() const;

    double pitch_;
};

DotsLocator::DotsLocator(Subject subject)
    : RoundLocator{std::move(subject)}, pitch_{subject_.target.pitch_mm / subject_.mm_per_px} {
    expect({0, 0, 0.5 * subject_.target.diameter_mm / subject_.mm_per_px, 1});
    if (!(size_ >= 1.5)) {
        throw InputError{
            fmt::format("{}: diameter_mm = {}; dots with a pitch require a diameter of at least 3 px",
                        subject_.label, subject_.target.diameter_mm)};
    }
    if (!(pitch_ > 2 * size_)) {
        throw InputError{fmt::format("{}: pitch_mm = {}; must exceed the dots' diameter", subject_.label,
                                     subject_.target.pitch_mm)};
    }
    ring_ = RingSearch{size_, 1, sign_};
}

void DotsLocator::find_dots(const ImageView& image, const Box& box, double contrast) {
    ring_.scan(image, box, contrast, 0.35, peaks_);
    std::vector<Outline> dots;
    prior_ = {.size = 0.5 + 0.1 * size_, .blur = 1.0, .sign = sign_};
    for (const RingPeak& peak : peaks_) {
        const EdgeFitResult fit = measure_peak(image, peak, contrast, 0.3);
        const auto same = [&](const Outline& o) {
            return length(place_of(fit) - Point{o.x, o.y}) < 0.5 * pitch_;
        };
        if (fit.converged && fit.trimmed < 0.3 && std::ranges::none_of(dots, same))
            dots.push_back(fit.outline);
    }
    if (dots.empty()) throw not_found("dots", size_);
    std::ranges::sort(dots, {}, [](const Outline& o) { return o.x + o.y; });
    Outline mean{0, 0, 0, 0};
    for (const Outline& o : dots) {
        const double share = 1.0 / static_cast<double>(dots.size());
        mean.x += share * o.x;
        mean.y += share * o.y;
        mean.size += share * o.size;
        mean.blur += share * o.blur;
    }
    expect(mean);
    discs_.clear();
    for (const Outline& o : dots) discs_.push_back({o.x - mean.x, o.y - mean.y});
    blocks_ = static_cast<int>(discs_.size());
}

void DotsLocator::check_pitch() const {
    if (discs_.size() < 2) return;
    std::vector<double> gaps;
    for (const Point& a : discs_) {
        double nearest = 1e9;
        for (const Point& b : discs_) {
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
    prior_ = {.size = 0.02, .blur = 0.5, .sign = sign_};
    ring_ = RingSearch{size_, blur_, sign_};
    const EdgeFitResult fit = measure(image, {learned_.x, learned_.y}, prior_);
    if (!fit.converged) throw InputError{subject_.label + ": the dots found do not share one size and blur"};
    const double mean_blur = blur_;  // of the dots by themselves, which the next fits start from
    begin(fit, levels, discs_);
    blur_ = mean_blur;
    return place_of(fit);
}

void DotsLocator::search(const ImageView& image, Point last, Sweep, std::vector<Candidate>& out) {
    fit_.forget();
    const int half = static_cast<int>(0.5 * pitch_);
    double best = 0.35 * static_cast<double>(discs_.size());
    Point at;
    bool any = false;
    const auto score = [&](Point centre) {
        double sum = 0;
        for (const Point& offset : discs_) {
            const Point dot = centre + offset;
            sum += ring_.score(image, static_cast<int>(std::lround(dot.x)),
                               static_cast<int>(std::lround(dot.y)), contrast_);
        }
        if (sum > best) best = sum, at = centre, any = true;
    };
    for (int j = -half; j <= half; j += 2)
        for (int i = -half; i <= half; i += 2) score(last + Point{double(i), double(j)});
    for (const Point near : {Point{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        if (any) score(at + near);
    Candidate candidate;
    if (any && locate(image, at, candidate)) out.push_back(candidate);
}

}  // namespace

std::unique_ptr<Locator> make_dots_locator(Subject subject) {
    return std::make_unique<DotsLocator>(std::move(subject));
}

}  // namespace shaker::tracking
