#pragma once
// Matched filters for an outline of known size and blur, at every sub-pixel place: the fast fit of a target
// that looks as it did.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tracking/image/edge_fit.hpp"
#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// The model of EdgeFit with size and blur known, linear in the grey levels: for each place on a grid of 1/8
/// px the derivatives of the outline, without what gain, offset and plane of a block explain, are tabulated
/// as weights of raw pixels. A block on flat ground measures one number, its outline's place outwards; a
/// small target on a plane measures place and size. The pixels' weights fade out beside the outline *at that
/// place*: a window that moved in whole pixels would let marks beside the outline jump in and out of it. A
/// step with a quarter of many blocks leads from a prediction near the place, one with all of them to it.
/// Between places of the grid the linear model errs by less than 4e-5 px for a blur of 0.76 px. Weights of a
/// block are computed when it is first seen at a place, and a few more in each accepted picture; nothing is
/// allocated after shape().
class OutlineBank {
public:
    /// A pixel by its whole-numbered place about the pixel nearest the centre, and its block's shift.
    struct Site {
        int x = 0, y = 0;
        int block = 0;
    };
    struct Shape {
        double size = 0, blur = 1;  // px
        double size_sd = 0.02;      // px, of the prior about `size`
        EdgeFit::Ground ground = EdgeFit::Ground::flat;
        double reach = 0;       // px beside the outline at which weights on flat ground have faded out
        double level = 0;       // grey level between inside and outside
        bool straight = false;  // edges across x at +-size instead of a circle; y is the start's
        // The last blocks, so many, show what the blocks before them show in the mean: noise that these have
        // in common, which they cannot see by their disagreement.
        int means = 0;
    };

    /// Sites are in the order of their blocks, rows and columns. shifts: of the blocks' centres from the
    /// common centre, px.
    void shape(const Shape& shape, std::vector<Site> sites, const std::vector<Point>& shifts);
    /// As EdgeFit::fit(), without its care for single pixels: `trimmed` is the share of pixels in blocks that
    /// do not fit. Not converged when the target is not within about 2 px of `start`. Pictures with 4 bytes a
    /// pixel hold means of grey levels as floats.
    /// slopes: of the blocks on planes; a block without is not used.
    EdgeFitResult fit(const ImageView& image, Point start, std::span<const KnownSlope> slopes = {});
    /// As EdgeFit::accept().
    void accept(std::span<KnownSlope> slopes = {});
    /// After a fit of this picture that converged: learns how far its steps are from the true ones. A bevel
    /// makes an edge of another shape than the model's, for which a step of the model is too short or too
    /// long.
    void learn_response(const ImageView& image, std::span<const KnownSlope> slopes = {});
    [[nodiscard]] double size() const noexcept { return shape_.size; }
    [[nodiscard]] double blur() const noexcept { return shape_.blur; }
    /// Variance of what the blocks' mean shows over that of independent noise, mean over the newest pictures;
    /// at least 1. fit() counts it.
    [[nodiscard]] double common() const noexcept { return std::max(1.0, common_); }
    /// Another size and blur, with the same pixels.
    void resize(double size, double blur) noexcept;

private:
    static constexpr int phases = 8;  // a pixel
    static constexpr int most_steps = 6;
    static constexpr int lanes = 4;  // pixels that are weighted at once
    struct Block {                   // at one place of the grid
        // Inverse of the normal equations of 1, E [, u, v], with the known slope of the ground.
        Eigen::Matrix4d ground;
        Eigen::Matrix<double, 2, 3> by_slope;  // of the scores, grey levels per px of known slope
        std::array<double, 2> squares{};       // sums of u^2, v^2
        Eigen::Matrix3d normal;                // information on x, y, size for a gain and variance of 1
        Eigen::Vector3d lead;                  // flat: from the one score to those of x, y, size
        double share = 1;                      // flat: variance of the score over its derivative
        double weight = 0;                     // sum over the pixels
        double outline = 0;                    // sum of dE/dr
        bool known = false;
    };
    struct Run {  // sites in one row
        int x = 0, y = 0, length = 0;
    };
    struct Range {
        int begin = 0, end = 0;              // sites
        int first_run = 0, last_run = 0;     // half-open
        int padded = 0, first = 0;           // sites in whole lanes, and those of the blocks before
        int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // of its pixels, both ends included
        Point shift;
    };
    struct Seen {  // a block in a picture
        double gain = 0, variance = 0, freedom = 0;
        Eigen::Vector3d score;
        bool used = false;
        double off = 0;  // px, of its outline outwards from the common one
        BlockHabit habit;
        // Gradient of the background over the contrast, 1/px. tilted() puts this picture's own value here.
        std::array<double, 2> slope{};
    };

    struct Step {  // sums over the blocks in use, and the change of x, y and size that they ask for, px
        Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
        Eigen::Vector3d score = Eigen::Vector3d::Zero(), change;
        double freedom = 0, squares = 0, outline = 0, used = 0, looked = 0;
    };
    [[nodiscard]] Eigen::Matrix3d certain(const Eigen::Matrix3d& normal, double variance) const;
    Step step_at(const ImageView& image, std::size_t place, int x, int y, bool thinned);
    [[nodiscard]] Step sums_at(std::size_t place, double looked) const;
    EdgeFitResult summed(const Step& step);
    double stranger(std::size_t block, std::size_t place, const Eigen::Vector3d& change, double variance);
    bool exclude_strangers(std::size_t place, const Step& step);
    [[nodiscard]] static Point offset_at(std::size_t place) noexcept;  // from the nearest whole pixel
    bool learn(std::size_t place, std::size_t block);                  // false: known already
    template <int nuisances>
    void learn(std::size_t place, std::size_t block);
    void learn_ahead();
    template <class T>
    void look(const Pixels<T>& pixels, std::size_t place, int x, int y, Box whole, bool thinned);
    template <bool flat>
    void see(std::size_t block, std::size_t place);
    [[nodiscard]] bool plane() const noexcept { return shape_.ground == EdgeFit::Ground::plane; }
    [[nodiscard]] bool is_mean(std::size_t block) const noexcept {
        return block + static_cast<std::size_t>(shape_.means) >= ranges_.size();
    }
    [[nodiscard]] std::array<double, 2> own_slope(std::size_t block, std::size_t place,
                                                  const Eigen::Vector3d& change) const;
    [[nodiscard]] double explained_by(const Eigen::Vector3d& change, std::size_t place,
                                      std::size_t block) const;
    [[nodiscard]] bool tilted(std::size_t place, const Eigen::Vector3d& change);
    [[nodiscard]] float* weights_of(std::size_t place, std::size_t block) const {
        return &weights_[place * weights_a_place_ +
                         columns_a_site() * static_cast<std::size_t>(ranges_[block].first)];
    }
    [[nodiscard]] std::size_t columns_a_site() const noexcept { return plane() ? 4 : 3; }
    [[nodiscard]] const Block& block_at(std::size_t place, std::size_t block) const {
        return blocks_[place * ranges_.size() + block];
    }
    void choose_blocks();
    double disagreement(std::size_t place, const Eigen::Vector3d& change, double variance);
    [[nodiscard]] double common_of(const Eigen::Vector3d& change, std::size_t place, double variance) const;
    double median_of(double Seen::*member);

    Shape shape_;
    std::vector<Site> sites_;
    std::vector<Run> runs_;
    std::vector<Range> ranges_;
    // For each place of the grid: one a block; and for each of its sites, one after the other, on flat ground
    // its weight and those of E and of the outwards place, on a plane those of E, x, y and size. Memory of
    // weights is touched when they are computed.
    std::vector<Block> blocks_;
    std::unique_ptr<float[]> weights_;
    std::size_t weights_a_place_ = 0;
    std::vector<float> along_, across_;  // places of the sites, as their weights lie
    std::vector<float> values_;          // of a block's pixels, in whole lanes
    float level_ = 0;
    std::vector<Seen> seen_;
    std::span<const KnownSlope> slopes_;  // during fit()
    std::vector<double> sorted_;
    // Columns of a block while its weights are computed, one row a site: 1, E, u, v, dE/dx, dE/dy, dE/dsize.
    Eigen::Matrix<double, Eigen::Dynamic, 7> columns_;
    Eigen::Matrix<double, Eigen::Dynamic, 7> faded_;  // the same by the weights of the sites
    double contrast_ = 0;
    double common_ = 1, common_frames_ = 0;
    double newest_common_ = 0;                   // of the newest fit; 0: not known
    double response_ = 1, response_frames_ = 0;  // of a step, over the true one
    // Of the newest step: its place, and of the last one of a fit the change that it asked for.
    int x_ = 0, y_ = 0;
    std::size_t place_ = 0;
    Eigen::Vector3d change_ = Eigen::Vector3d::Zero();
    bool whole_ = false;                       // all blocks that were looked at are in it
    std::size_t ahead_ = 0, first_ahead_ = 0;  // blocks that learn_ahead() has passed, from this place on
};

}  // namespace shaker::tracking
