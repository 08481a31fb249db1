#pragma once
// Locator for bars of irregular width: matched filters on parts of the strip.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "tracking/image/region.hpp"
#include "tracking/image/strip.hpp"
#include "tracking/locator.hpp"

namespace shaker::tracking {

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

}  // namespace shaker::tracking
