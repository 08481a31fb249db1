// Locator for periodic bars: phase of their fundamental.
#include <spdlog/fmt/fmt.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "tracking/image/region.hpp"
#include "tracking/image/strip.hpp"
#include "tracking/locator.hpp"

namespace shaker::tracking {

namespace {

/// Position = pitch * phase / 2 pi of the fundamental, from overlapping Hann windows of three periods that
/// follow the bars in whole pixels. Each window is compared with its own phase in frame 0; hidden windows are
/// excluded. Measures along the image axis nearest to the shaker's; the other coordinate is the region's
/// middle. Bars are periodic: a frame is unambiguous only within half a pitch of the prediction, and after a
/// loss the search covers half a pitch around the last position.
class BarsLocator final : public Locator {
public:
    explicit BarsLocator(Subject subject);
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 0.4 * pitch_; }
    [[nodiscard]] double extent() const noexcept override { return 0.5 * pitch_; }
    [[nodiscard]] double pitch() const noexcept override { return pitch_; }
    [[nodiscard]] std::optional<Correction> correction() const override {
        return correction_of("pitch_mm", subject_.target.pitch_mm,
                             crossing_px(subject_, subject_.target.pitch_mm), pitch_);
    }
    [[nodiscard]] bool interchangeable() const noexcept override { return false; }

private:
    using Complex = std::complex<double>;
    struct Window {
        double centre = 0;  // in frame 0
        std::size_t band = 0;
        int first = 0;               // pixel of the first weight, in frame 0
        Eigen::MatrixX2f weights{};  // real and imaginary part
        Complex learned{}, now{};    // fundamental in frame 0 and in this one
        double learned_strength = 0;
    };

    void tabulate(Window& w) const;
    [[nodiscard]] Complex look(const Window& w, int moved) const;
    [[nodiscard]] Complex fundamental(std::size_t band, double centre, double pitch, double periods) const;
    double refine_pitch(double middle, double guess, double range) const;
    double strongest_pitch(double middle) const;
    bool measure(const ImageView& image, double shift, Candidate& out);

    Subject subject_;
    Axis axis_;
    double pitch_;
    Point learned_;
    std::vector<Window> windows_;
    std::vector<StripPart> parts_;  // the windows in this picture; off: beside their whole pixels
    StripProfiles profiles_;
    std::vector<double> scratch_;
};

constexpr double tau = 2 * std::numbers::pi;
constexpr double periods_per_window = 3;
constexpr int enough = 100;  // windows; more do not show better where the bars are hidden

// As std::arg(), to 1e-7, and faster where the angle is small.
double angle(std::complex<double> z) noexcept {
    if (!(std::abs(z.imag()) < 0.2 * z.real())) return std::arg(z);
    const double t = z.imag() / z.real(), t2 = t * t;
    return t * (1 - t2 * (1.0 / 3 - t2 * (1.0 / 5 - t2 / 7)));
}

BarsLocator::BarsLocator(Subject subject)
    : subject_{std::move(subject)},
      axis_{axis_of(subject_)},
      pitch_{crossing_px(subject_, subject_.target.pitch_mm)} {}

// sum of hann(x) profile(x) exp(-i 2 pi (x - centre) / pitch).
BarsLocator::Complex BarsLocator::fundamental(std::size_t band, double centre, double pitch,
                                              double periods) const {
    const double half = 0.5 * periods * pitch;
    const int first = static_cast<int>(std::ceil(centre - half)),
              last = static_cast<int>(std::floor(centre + half));
    const float* const profile = profiles_.at(band, first, last - first + 1);
    if (profile == nullptr) return {0, 0};
    const double from = first - centre;
    Complex carrier = std::polar(1.0, -tau * from / pitch), taper = std::polar(1.0, tau * from / (2 * half));
    const Complex carrier_step = std::polar(1.0, -tau / pitch),
                  taper_step = std::polar(1.0, tau / (2 * half));
    Complex sum{0, 0};
    double plain = 0;
    for (int x = first; x <= last; ++x) plain += profile[x - first];
    plain /= last - first + 1;
    for (int x = first; x <= last; ++x) {
        const double w = 0.5 + 0.5 * taper.real();
        const double value = w * (profile[x - first] - plain);
        sum += value * carrier;
        carrier *= carrier_step;
        taper *= taper_step;
    }
    return sum;
}

// The weights of fundamental() about the centre of a window, as it is found in every picture.
void BarsLocator::tabulate(Window& w) const {
    const double half = 0.5 * periods_per_window * pitch_;
    w.first = static_cast<int>(std::ceil(w.centre - half));
    const int last = static_cast<int>(std::floor(w.centre + half));
    Eigen::MatrixX2d weights(last - w.first + 1, 2);
    for (int i = 0; i < weights.rows(); ++i) {
        const double u = w.first + i - w.centre;
        const Complex weight =
            (0.5 + 0.5 * std::cos(tau * u / (2 * half))) * std::polar(1.0, -tau * u / pitch_);
        weights.row(i) << weight.real(), weight.imag();
    }
    weights.rowwise() -= weights.colwise().mean().eval();  // of what does not change along the bars
    w.weights = weights.cast<float>();
}

// fundamental() at a window that is moved by whole pixels.
BarsLocator::Complex BarsLocator::look(const Window& w, int moved) const {
    const float* const profile = profiles_.at(w.band, w.first + moved, static_cast<int>(w.weights.rows()));
    if (profile == nullptr) return {0, 0};
    const Eigen::Map<const Eigen::VectorXf> seen{profile, w.weights.rows()};
    return {seen.dot(w.weights.col(0)), seen.dot(w.weights.col(1))};
}

double BarsLocator::strongest_pitch(double middle) const {
    const double span = static_cast<double>(profiles_.band(0).size());
    const double slowest = periods_per_window / span;
    double best = 0, pitch = 0;
    for (double f = slowest; f < 0.25; f += 0.1 / span) {
        const double strength = std::abs(fundamental(0, middle, 1 / f, std::floor(span * f)));
        if (strength > best) best = strength, pitch = 1 / f;
    }
    return pitch;
}

// Golden-section search for the pitch with the strongest fundamental over the whole region.
double BarsLocator::refine_pitch(double middle, double guess, double range) const {
    const double periods =
        std::floor((static_cast<double>(profiles_.band(0).size()) - 1) / (guess * (1 + range)));
    const auto strength = [&](double pitch) {
        return std::abs(fundamental(0, middle, pitch, periods)) / pitch;
    };
    constexpr double golden = 0.6180339887498949;
    double a = guess * (1 - range), b = guess * (1 + range);
    for (int i = 0; i < 40; ++i) {
        const double c = b - golden * (b - a), d = a + golden * (b - a);
        if (strength(c) > strength(d))
            b = d;
        else
            a = c;
    }
    return 0.5 * (a + b);
}

Point BarsLocator::learn(const ImageView& image) {
    const Box box = region_in(subject_, image);
    const Levels levels = levels_in(subject_, image, box);
    const int first = axis_ == Axis::x ? box.x0 : box.y0, last = axis_ == Axis::x ? box.x1 : box.y1;
    const int across0 = axis_ == Axis::x ? box.y0 : box.x0, across1 = axis_ == Axis::x ? box.y1 : box.x1;
    profiles_.place(axis_, across0, across1, 1);  // all rows at once until the pitch is known
    profiles_.load(image, first, last);
    const double middle = 0.5 * (first + last - 1), span = last - first;
    const double given = pitch_;
    if (!(pitch_ > 0)) pitch_ = strongest_pitch(middle);
    if (!(pitch_ >= 3.5) || (periods_per_window + 0.25) * pitch_ > span) {
        throw InputError{fmt::format(
            "{}: pitch is {:.4g} px; must be at least 3.5 px, and 3.25 pitches must fit into the region",
            subject_.label, pitch_)};
    }
    pitch_ = refine_pitch(middle, pitch_, std::min(0.05, 0.5 * pitch_ / span));
    const double half = 0.5 * periods_per_window * pitch_;
    const double room = span - 1 - 2 * half;
    const int steps = static_cast<int>(std::floor(room / half));
    const int bands = std::clamp(std::min((across1 - across0) / 6, enough / (steps + 1)), 1, 4);
    profiles_.place(axis_, across0, across1, static_cast<std::size_t>(bands));
    profiles_.load(image, first, last);
    windows_.clear();
    Complex sum{0, 0};
    for (std::size_t band = 0; band < profiles_.bands(); ++band) {
        for (int k = 0; k <= steps; ++k) {
            Window w;
            w.centre = middle + half * (k - 0.5 * steps);
            w.band = band;
            tabulate(w);
            w.learned = look(w, 0);
            w.learned_strength = std::abs(w.learned);
            // The carriers have their common origin in the middle, so that the windows of regular bars agree
            // in phase.
            sum += w.learned * std::polar(1.0, -tau * (w.centre - middle) / pitch_);
            windows_.push_back(w);
        }
    }
    parts_.assign(windows_.size(), {});
    const double amplitude = 4 * std::abs(sum) / (static_cast<double>(windows_.size()) * 2 * half);
    if (!(amplitude > 0.15 * (levels.high - levels.low))) {
        throw InputError{fmt::format("{}: found no bars of {:.4g} px pitch; check the region and pitch_mm",
                                     subject_.label, given > 0 ? given : pitch_)};
    }
    const double sign = subject_.target.polarity == Polarity::bright ? 0 : std::numbers::pi;
    const double along = middle + pitch_ / tau * std::remainder(-std::arg(sum) + sign, tau);
    const double across = profiles_.middle_across();
    learned_ = axis_ == Axis::x ? Point{along, across} : Point{across, along};
    return learned_;
}

bool BarsLocator::measure(const ImageView& image, double shift, Candidate& out) {
    const int whole_px = static_cast<int>(std::lround(shift));
    const double half = 0.5 * periods_per_window * pitch_, per_radian = pitch_ / tau;
    profiles_.load(image, static_cast<int>(std::floor(windows_.front().centre - half)) + whole_px - 1,
                   static_cast<int>(std::ceil(windows_.back().centre + half)) + whole_px + 2);
    Complex all{0, 0};
    for (Window& w : windows_) {
        w.now = look(w, whole_px);
        all += std::conj(w.learned) * w.now;
    }
    // The mean of Hann squared is 3/8.
    const double noise = profiles_.noise(image) * std::sqrt(0.5 * 0.375 * 2 * half);
    for (std::size_t i = 0; i < windows_.size(); ++i) {
        const Window& w = windows_[i];
        // Relative to the common phase, so that no window is off by a whole pitch.
        const double turn = angle(std::conj(w.learned) * w.now * std::conj(all));
        const double weight = std::norm(w.now), strength = std::sqrt(weight);
        parts_[i] = {strength / w.learned_strength, noise / w.learned_strength,
                     -per_radian * (turn + std::arg(all)), per_radian * noise / strength, weight};
    }
    exclude_hidden(parts_, 1e-3 * pitch_, scratch_);
    const StripMean mean = mean_of(parts_, windows_.size() / profiles_.bands());
    const double total = static_cast<double>(windows_.size()), used = mean.used;
    if (!(used > 0) || used < 0.2 * total || mean.gain < 0.3 * used || mean.gain > 3 * used) return false;
    // Neighbours overlap by half and share a sixth of their noise: twice that is added to the independent
    // sum.
    const bool overlap = used > static_cast<double>(profiles_.bands());
    const double sd = std::hypot(
        per_radian * noise * std::sqrt((1 + (overlap ? 1.0 / 3 : 0.0)) / mean.weight) * mean.excess,
        mean.apart);
    const double along = whole_px + mean.off, across = axis_ == Axis::x ? learned_.y : learned_.x;
    out.at = axis_ == Axis::x ? Point{learned_.x + along, across} : Point{across, learned_.y + along};
    out.sd = sd;
    out.likeness = used / total;
    out.degraded = used < 0.75 * total;
    return sd < 0.1 * pitch_;
}

bool BarsLocator::locate(const ImageView& image, Point predicted, Candidate& out) {
    const double shift = axis_ == Axis::x ? predicted.x - learned_.x : predicted.y - learned_.y;
    if (!measure(image, shift, out)) return false;
    const double found = axis_ == Axis::x ? out.at.x - learned_.x : out.at.y - learned_.y;
    // The windows' whole-pixel positions must not depend on the rounding of the prediction.
    if (std::lround(found) != std::lround(shift) && !measure(image, found, out)) return false;
    const double again = axis_ == Axis::x ? out.at.x - learned_.x : out.at.y - learned_.y;
    return std::abs(again - shift) <= reach();
}

void BarsLocator::search(const ImageView& image, Point last, Sweep, std::vector<Candidate>& out) {
    Candidate candidate;
    if (locate(image, last, candidate)) out.push_back(candidate);
}

}  // namespace

std::unique_ptr<Locator> make_bars_locator(Subject subject) {
    return std::make_unique<BarsLocator>(std::move(subject));
}

}  // namespace shaker::tracking
