// Locator for bars of irregular width: matched filters on parts of the strip.
#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "tracking/image/bar_fit.hpp"
#include "tracking/image/profile.hpp"
#include "tracking/image/region.hpp"
#include "tracking/image/strip.hpp"
#include "tracking/locator.hpp"

namespace shaker::tracking {

namespace {

/// Learns the bars' edges, levels and blur from frame 0 and tabulates, for each of 32 fractions of a pixel
/// and each segment of four edges, the least-squares filters of the model
///   I(x) = a T(x) + m T'(x) + b + c x + d x T(x) + e dT/dblur,   shift = -m / a
/// with the bars T as in frame 0. Segments whose contrast a or shift differs from the others' are excluded.
/// Measures along the image axis nearest to the shaker's; the place is the middle between the first and the
/// last edge, the other coordinate the region's middle. The bars are found anywhere in the picture by the
/// correlation of their profile, so the place is absolute: no pitch, and no slip after a loss.
class CodeLocator final : public Locator {
public:
    explicit CodeLocator(Subject subject);
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 3; }
    [[nodiscard]] double extent() const noexcept override { return narrowest_; }
    [[nodiscard]] bool interchangeable() const noexcept override { return false; }

private:
    struct Segment {
        int first = 0, count = 0;  // px in frame 0
        Eigen::Index from = 0;     // row of the tables
    };
    /// For one fraction of a pixel. Columns: filter of m, filter of a, T without its line.
    struct Bank {
        Eigen::Matrix<float, Eigen::Dynamic, 3> pixels;
        Eigen::Matrix<double, Eigen::Dynamic, 3> norms;  // of the columns in each segment
    };
    /// Energies of a part's pixels without their line: all of it but the noise's, and that of the bars in
    /// frame 0.
    struct Resemblance {
        double all = 0, bars = 0;
        void add(const Resemblance& other) noexcept { all += other.all, bars += other.bars; }
        [[nodiscard]] bool above(double correlation) const noexcept {
            return bars > correlation * correlation * all;
        }
        /// 1 less the correlation.
        [[nodiscard]] double lack() const noexcept { return 1 - std::sqrt(std::min(bars / all, 1.0)); }
    };
    /// How a place was come by: near the last one, or anywhere in the picture.
    enum class Start { followed, searched };

    void tabulate(const struct BarModel& model);
    double apply(int at, std::size_t bands);
    [[nodiscard]] const float* seen_at(std::size_t part, int moved) const;
    [[nodiscard]] Resemblance resemblance(std::size_t part, int at, double noise) const;
    bool measure(const ImageView& image, double shift, Start start, Candidate& out);
    void outline(const ImageView& image, int first, int last, std::vector<float>& out);
    void correlate(const std::vector<float>& seen);
    [[nodiscard]] double best_and_clear();

    Subject subject_;
    Axis axis_;
    double narrowest_ = 0;  // bar, px
    Point learned_;
    std::vector<Segment> segments_;
    std::vector<Bank> banks_;       // one per fraction
    Eigen::VectorXf line_;          // of each segment, of unit energy
    std::vector<StripPart> parts_;  // segments of band 0, then of band 1, ...
    StripProfiles profiles_, all_rows_;
    std::vector<double> scratch_;
    std::vector<float> outline_, seen_, scores_;  // changes of the profile, in steps of 2 px
    std::vector<double> energy_;
};

constexpr int phases = 32;  // per pixel
constexpr std::size_t edges_per_segment = 4, fewest_edges = 8;
constexpr int enough_parts = 50;  // more do not show better where the strip is hidden
constexpr double narrowest_px = 3;
constexpr int beside = 4;                 // px read beside the strip: more than reach()
constexpr double least_likeness = 0.85;   // correlation of a visible segment with frame 0
constexpr double sharp_likeness = 0.988;  // of all of them, unless the blur is twice that of frame 0
constexpr double blurred_sd = 0.04;       // px, of places in pictures that are so blurred
// Error of a place, px, over 1 less the correlation: 3.5 just out of focus, 1.9 at the worst that counts as
// sharp.
constexpr double sd_per_lack = 3;
constexpr double most_repeat = 0.75;   // correlation of a strip with itself elsewhere
constexpr double least_visible = 0.2;  // share of a strip
constexpr double stretch = 0.005;      // of a moved picture of the strip, by lens and perspective
constexpr int per_step = 2;            // px; the search compares profiles in such steps

// The whole pixels below a number of fractions.
int whole_px(int at) { return at >= 0 ? at / phases : (at - phases + 1) / phases; }

CodeLocator::CodeLocator(Subject subject) : subject_{std::move(subject)}, axis_{axis_of(subject_)} {}

Point CodeLocator::learn(const ImageView& image) {
    const Box box = region_in(subject_, image);
    const Levels levels = levels_in(subject_, image, box);
    const int first = axis_ == Axis::x ? box.x0 : box.y0, last = axis_ == Axis::x ? box.x1 : box.y1;
    const int across0 = axis_ == Axis::x ? box.y0 : box.x0, across1 = axis_ == Axis::x ? box.y1 : box.x1;
    all_rows_.place(axis_, across0, across1, 1);
    all_rows_.load(image, first, last);
    const std::vector<double> profile{all_rows_.band(0).begin(), all_rows_.band(0).end()};
    BarModel model = fit_bars(profile);
    const auto [low, high] = std::ranges::minmax(profile);
    narrowest_ = model.narrowest();
    if (model.edges.size() < fewest_edges || high - low < 0.3 * (levels.high - levels.low) ||
        narrowest_ < narrowest_px || model.explained < 0.9)
        throw InputError{subject_.label +
                         ": found no bars across the shaker's axis; the region must hold at "
                         "least 8 edges, 3 px or more apart, and nothing else"};
    for (double& edge : model.edges) edge += first;
    const std::size_t edges = model.edges.size(), count = edges / edges_per_segment;
    const auto boundary = [&](std::size_t k) {  // before edge k
        const double before = k == 0 ? 2 * model.edges[0] - model.edges[1] : model.edges[k - 1];
        const double after = k == edges ? 2 * model.edges[k - 1] - model.edges[k - 2] : model.edges[k];
        return std::clamp(static_cast<int>(std::lround(0.5 * (before + after))), first, last);
    };
    segments_.clear();
    for (std::size_t j = 0; j < count; ++j) {
        // Even numbers of edges: a change of the blur or of the exposure then moves none of the segments.
        const int from = boundary(edges / 2 * j / count * 2);
        const int to = boundary(j + 1 == count ? edges : edges / 2 * (j + 1) / count * 2);
        segments_.push_back({from, to - from, from - boundary(0)});
    }
    tabulate(model);
    const int bands = std::clamp(
        std::min((across1 - across0) / 6, enough_parts / static_cast<int>(segments_.size())), 1, 4);
    profiles_.place(axis_, across0, across1, static_cast<std::size_t>(bands));
    parts_.assign(segments_.size() * profiles_.bands(), {});
    outline(image, segments_.front().first, segments_.back().first + segments_.back().count, outline_);
    seen_.reserve(static_cast<std::size_t>(length_along(image, axis_)));
    correlate(outline_);
    const auto same = scores_.begin() + static_cast<std::ptrdiff_t>(scores_.size() / 2);
    std::fill(same - 2, same + 3, 0.0F);
    if (*std::ranges::max_element(scores_) > most_repeat)
        throw InputError{
            subject_.label +
            ": the bars repeat, so their place is ambiguous; use kind = \"bars\" for regular ones"};
    const double along = 0.5 * (model.edges.front() + model.edges.back()), across = profiles_.middle_across();
    learned_ = axis_ == Axis::x ? Point{along, across} : Point{across, along};
    return learned_;
}

void CodeLocator::tabulate(const BarModel& model) {
    const Eigen::Index all = segments_.back().from + segments_.back().count;
    line_.resize(all);
    for (const Segment& s : segments_)
        line_.segment(s.from, s.count) = Eigen::VectorXf::LinSpaced(s.count, -1, 1).normalized();
    banks_.resize(phases);
    for (int q = 0; q < phases; ++q) {
        Bank& bank = banks_[static_cast<std::size_t>(q)];
        bank.pixels.resize(all, 3);
        bank.norms.resize(static_cast<Eigen::Index>(segments_.size()), 3);
        for (std::size_t s = 0; s < segments_.size(); ++s) {
            const auto& [first, count, from] = segments_[s];
            Eigen::Matrix<double, Eigen::Dynamic, 6> model_of(count, 6);  // T', T, 1, x, x T, dT/dblur
            for (int i = 0; i < count; ++i) {
                const auto [level, slope, by_blur] = model.at(first + i - q / static_cast<double>(phases));
                const double x = (2.0 * i + 1) / count - 1;
                model_of.row(i) << slope, level, 1, x, x * level, by_blur;
            }
            const Eigen::MatrixXd line = model_of.middleCols<2>(2);
            const Eigen::VectorXd pattern = model_of.col(1);
            model_of.col(1) -= line * line.householderQr().solve(pattern).eval();
            auto pixels = bank.pixels.middleRows(from, count);
            pixels.col(2) = model_of.col(1).cast<float>();
            const Eigen::MatrixXd inverse = model_of.completeOrthogonalDecomposition().pseudoInverse();
            pixels.leftCols(2) = inverse.topRows(2).transpose().cast<float>();
            bank.norms.row(static_cast<Eigen::Index>(s)) = pixels.cast<double>().colwise().norm();
        }
    }
}

// Fills the parts of so many bands for a shift of `at` fractions; returns how far off it is by all of them,
// px.
double CodeLocator::apply(int at, std::size_t bands) {
    const int moved = whole_px(at);
    const Bank& bank = banks_[static_cast<std::size_t>(at - moved * phases)];
    double sum = 0, weight = 0;
    for (std::size_t i = 0; i < bands * segments_.size(); ++i) {
        const auto s = static_cast<Eigen::Index>(i % segments_.size());
        const auto& [first, count, from] = segments_[static_cast<std::size_t>(s)];
        StripPart& p = parts_[i] = {};
        const float* const profile = seen_at(i, moved);
        if (profile == nullptr) continue;
        const Eigen::Map<const Eigen::VectorXf> seen{profile, count};
        const double m = seen.dot(bank.pixels.col(0).segment(from, count)), norm = bank.norms(s, 0);
        p.gain = seen.dot(bank.pixels.col(1).segment(from, count));
        p.gain_sd = bank.norms(s, 1);  // of unit noise
        p.off = -m / p.gain;
        p.off_sd = norm / std::abs(p.gain);
        p.weight = p.gain * p.gain / (norm * norm);
        if (!(p.gain > 0)) continue;
        sum -= m * p.gain / (norm * norm);
        weight += p.weight;
    }
    return weight > 0 ? sum / weight : 0;
}

// A part's profile; nullptr if not all of it was read.
const float* CodeLocator::seen_at(std::size_t part, int moved) const {
    const Segment& s = segments_[part % segments_.size()];
    return profiles_.at(part / segments_.size(), s.first + moved, s.count);
}

CodeLocator::Resemblance CodeLocator::resemblance(std::size_t part, int at, double noise) const {
    const int moved = whole_px(at);
    const Bank& bank = banks_[static_cast<std::size_t>(at - moved * phases)];
    const auto s = static_cast<Eigen::Index>(part % segments_.size());
    const auto& [first, count, from] = segments_[static_cast<std::size_t>(s)];
    const float* const profile = seen_at(part, moved);
    if (profile == nullptr) return {1, 0};
    const Eigen::Map<const Eigen::ArrayXf> seen{profile, count};
    const float mean = seen.mean();
    const double slope = seen.matrix().dot(line_.segment(from, count));
    const double energy = (seen - mean).square().sum() - slope * slope;
    const double likeness =
        std::max(0.0F, seen.matrix().dot(bank.pixels.col(2).segment(from, count))) / bank.norms(s, 2);
    return {std::max(energy - count * noise * noise, 0.0), likeness * likeness};
}

bool CodeLocator::measure(const ImageView& image, double shift, Start start, Candidate& out) {
    constexpr int most_passes = 8;
    const Segment& end = segments_.back();
    const int middle = static_cast<int>(std::lround(shift));
    profiles_.load(image, segments_.front().first + middle - beside, end.first + end.count + middle + beside);
    if (profiles_.band(0).empty()) return false;
    const double noise = profiles_.noise(image), total = static_cast<double>(parts_.size());
    int at = 0;
    StripMean mean;
    for (int pass = 0;; ++pass) {
        if (pass == most_passes || std::abs(shift - middle) > beside - 0.5) return false;
        at = static_cast<int>(std::lround(phases * shift));
        const double tabulated = at / static_cast<double>(phases),
                     off = apply(at, pass == 0 ? 1 : profiles_.bands());
        const bool near = pass > 0 && std::abs(off) < 2.0 / phases;
        if (!near && pass < most_passes - 2) {
            shift = tabulated + std::clamp(off, -1.0, 1.0);
            continue;
        }
        for (StripPart& p : parts_) p.gain_sd *= noise, p.off_sd *= noise;
        exclude_hidden(parts_, 0.01 + stretch * std::abs(shift), scratch_);
        mean = mean_of(parts_, segments_.size());
        if (!(mean.used > 0)) return false;
        shift = tabulated + mean.off;
        if (std::abs(mean.off) < 2.0 / phases) break;
    }
    if (start == Start::searched || mean.used < 0.75 * total) {
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const bool alike = resemblance(i, at, noise).above(least_likeness);
            parts_[i].used = parts_[i].used && alike;
            parts_[i].apart = parts_[i].apart && alike;
        }
        mean = mean_of(parts_, segments_.size());
        shift = at / static_cast<double>(phases) + mean.off;
    }
    const double used = mean.used;
    if (mean.places < 2 || used < least_visible * total || mean.gain < 0.2 * used || mean.gain > 5 * used)
        return false;
    const double along = shift, across = axis_ == Axis::x ? learned_.y : learned_.x;
    out.at = axis_ == Axis::x ? Point{learned_.x + along, across} : Point{across, learned_.y + along};
    out.sd = std::hypot(noise / std::sqrt(mean.weight) * mean.excess, mean.apart);
    out.likeness = used / total;
    Resemblance all;
    for (std::size_t i = 0; i < segments_.size(); ++i)
        if (parts_[i].used) all.add(resemblance(i, at, noise));
    const bool blurred = !all.above(sharp_likeness);
    out.sd = std::hypot(out.sd, blurred ? blurred_sd : sd_per_lack * all.lack());
    out.degraded = used < 0.75 * total || blurred;
    return out.sd < 0.05 * narrowest_;
}

bool CodeLocator::locate(const ImageView& image, Point predicted, Candidate& out) {
    const double shift = axis_ == Axis::x ? predicted.x - learned_.x : predicted.y - learned_.y;
    return measure(image, shift, Start::followed, out);
}

// Differences of the profile's means over steps.
void CodeLocator::outline(const ImageView& image, int first, int last, std::vector<float>& out) {
    all_rows_.load(image, first, last);
    const std::span<const float> profile = all_rows_.band(0);
    out.clear();
    for (std::size_t i = 0; i + 3 * per_step <= profile.size(); i += per_step) {
        float change = 0;
        for (std::size_t k = 0; k < per_step; ++k) change += profile[i + 2 * per_step + k] - profile[i + k];
        out.push_back(change);
    }
}

// scores_[k]: correlation of the learned outline, moved by k + 1 - its length, with `seen`.
void CodeLocator::correlate(const std::vector<float>& seen) {
    const auto n = static_cast<Eigen::Index>(outline_.size()), wide = static_cast<Eigen::Index>(seen.size());
    const Eigen::Map<const Eigen::VectorXf> pattern{outline_.data(), n}, all{seen.data(), wide};
    energy_.assign(1, 0);
    for (const float v : seen) energy_.push_back(energy_.back() + double{v} * double{v});
    scores_.clear();
    const double own = pattern.squaredNorm();
    for (Eigen::Index k = 1 - n; k < wide; ++k) {
        const Eigen::Index from = std::max<Eigen::Index>(0, -k), to = std::min(n, wide - k);
        float score = 0;
        if (static_cast<double>(to - from) > least_visible * static_cast<double>(n)) {
            const double energy =
                energy_[static_cast<std::size_t>(to + k)] - energy_[static_cast<std::size_t>(from + k)];
            const auto overlap =
                static_cast<double>(pattern.segment(from, to - from).dot(all.segment(from + k, to - from)));
            if (energy > 0) score = static_cast<float>(overlap / std::sqrt(own * energy));
        }
        scores_.push_back(score);
    }
}

// The shift of the highest score, in steps, which is then cleared.
double CodeLocator::best_and_clear() {
    const auto best = std::ranges::max_element(scores_);
    const auto k = best - scores_.begin();
    double shift = static_cast<double>(k + 1) - static_cast<double>(outline_.size());
    if (k > 0 && best + 1 != scores_.end()) {
        const double left = best[-1], here = best[0], right = best[1];
        if (2 * here > left + right) shift += 0.5 * (left - right) / (left - 2 * here + right);
    }
    std::fill(best - std::min<std::ptrdiff_t>(k, 2), best + std::min<std::ptrdiff_t>(scores_.end() - best, 3),
              0.0F);
    return shift;
}

void CodeLocator::search(const ImageView& image, Point, Sweep, std::vector<Candidate>& out) {
    constexpr int tries = 4;
    outline(image, 0, length_along(image, axis_), seen_);
    correlate(seen_);
    for (int i = 0; i < tries; ++i) {
        const double shift = per_step * best_and_clear() - segments_.front().first;
        Candidate candidate;
        if (measure(image, shift, Start::searched, candidate)) {
            out.push_back(candidate);
            return;
        }
    }
}

}  // namespace

std::unique_ptr<Locator> make_code_locator(Subject subject) {
    return std::make_unique<CodeLocator>(std::move(subject));
}

}  // namespace shaker::tracking
