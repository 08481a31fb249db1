#pragma once
// Least-squares fit of a blurred outline to raw pixels, used for discs, dots and rectangles.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <vector>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// A pixel (or mean of pixels) near the outline. Samples of one block share gain and offset.
struct EdgeSample {
    double u = 0, v = 0;  // px, relative to the common centre plus the block's own shift
    double value = 0;     // grey level
    int block = 0;
};

/// The outline: r = hypot(u - x, v - y) = size. With v = y for all samples it is a slab of half-width `size`.
struct Outline {
    double x = 0, y = 0;
    double size = 0;  // radius or half-width, px
    double blur = 1;  // standard deviation of the edge, px; includes the pixel's own box
};

/// Diameter of a disc with this outline, px. Blur moves the half level of a curved edge inwards by
/// blur^2 / (2 radius).
inline double disc_diameter(const Outline& o) { return 2 * o.size + o.blur * o.blur / o.size; }

/// Prior: standard deviations about the starting outline, px; 0 fixes a quantity.
struct EdgePrior {
    double x = 1e6, y = 1e6, size = 1e6, blur = 1e6;
    double sign = 0;        // of the contrast; 0: either sign, and any roughness
    double roughest = 0.4;  // residual / contrast above which the fit is given up
    double reach = 1e6;     // px beside the outline at which samples on flat ground have faded out
};

struct EdgeFitResult {
    Outline outline;
    bool converged = false;
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of x, y
    double contrast = 0;            // grey levels, inside minus outside, median over the blocks in use
    double noise = 0;               // grey levels, rms of the residuals in use
    double freedom = 0;             // samples in use, less what is fitted to each block
    double coverage = 0;            // outline in use, in weight of samples
    double trimmed = 0;             // share of samples excluded as outliers
    double bent = 0;                // px, rms disagreement of the blocks where it is far beyond their noise
    std::array<double, 2> slope{};  // of the ground over the contrast, mean over the blocks in use, 1/px
};

/// Slope of the ground of a block over its contrast, which light that flickers does not change, learned from
/// earlier frames. It counts as much as `frames` frames, unless this frame's own slope differs from it.
struct KnownSlope {
    static constexpr double most_frames = 4;
    static constexpr double errors = 3;  // standard errors of this frame's own slope
    std::array<double, 2> slope{};       // along u and v, 1/px
    double frames = 0;

    /// own: of one frame alone.
    void learn(const std::array<double, 2>& own) noexcept {
        frames = std::min(frames + 1, most_frames);
        for (std::size_t i = 0; i < 2; ++i) slope.at(i) += (own.at(i) - slope.at(i)) / frames;
    }
    /// variance: of a grey level over the squared contrast. squares: sums of u^2, v^2 over the pixels.
    [[nodiscard]] bool differs(const std::array<double, 2>& own, double variance,
                               const std::array<double, 2>& squares) const noexcept {
        for (std::size_t i = 0; i < 2; ++i) {
            const double off = own.at(i) - slope.at(i);
            if (off * off * squares.at(i) > errors * errors * variance * (1 + 1 / frames)) return true;
        }
        return false;
    }
};

/// How a block used to differ from the others, over accepted pictures.
struct BlockHabit {
    static constexpr double longest_memory = 32;  // pictures
    double off = 0;                               // px, of its outline outwards from the common one
    double ratio = 1;                             // of its gain to the common one
    double frames = 0;

    void learn(double new_off, double new_ratio) noexcept {
        frames = std::min(frames + 1, longest_memory);
        off += (new_off - off) / frames;
        ratio += (new_ratio - ratio) / frames;
    }
    /// The block was not used: what it used to be is forgotten with time.
    void pass_over() noexcept {
        if (frames > 0 && --frames <= 0) *this = {};
    }
    /// Variance of `off` and of one picture, over that of one picture.
    [[nodiscard]] double known() const noexcept { return frames > 0 ? 1 + 1 / frames : 1; }
    /// A gain that is far from the others', or from what it used to be: the block shows something else.
    [[nodiscard]] bool strange(double new_ratio) const noexcept {
        const double change = new_ratio / ratio;
        return !(new_ratio > 0.4 && new_ratio < 2.5 && (frames <= 0 || (change > 0.6 && change < 1.7)));
    }
};

/// Model: I = offset_b + gain_b E(r - size; blur) [+ plane_b], with E(d; s) = Phi(-d/s) the Gaussian edge and
/// b the block; Gauss-Newton on x, y, size, blur with Tukey's biweight. Gain, offset and plane are eliminated
/// for each block, so uneven light causes no bias. Blocks and samples that do not fit are excluded. Scratch
/// memory is kept: a second fit of the same size does not allocate.
class EdgeFit {
public:
    enum class Ground { flat, plane };

    /// upright: the outline lies along rows or columns of pixels.
    explicit EdgeFit(bool upright = false) noexcept : upright_{upright} {}
    std::vector<EdgeSample>& samples() noexcept { return samples_; }
    /// Stops when a step is shorter than `enough` px (the error is then far smaller) or after `passes`
    /// passes.
    EdgeFitResult fit(const Outline& start, const EdgePrior& prior, int blocks, Ground ground,
                      int passes = 14, double enough = 3e-3);
    /// Confirms that the last fit was the target. Constant disagreement between blocks (print on the target)
    /// is learned from such fits and no longer counted as error; so is the slope of the ground.
    void accept();
    /// Forgets what accept() has learned: elsewhere, or after a loss, the light is another.
    void forget() noexcept;
    /// One a block, learned by accept().
    [[nodiscard]] std::vector<KnownSlope>& slopes() noexcept { return slopes_; }

private:
    // Columns of a block's normal equations: 1, E [, u, v] | d/dx, d/dy, d/dsize, d/dblur, value. Only the
    // upper triangle is summed.
    static constexpr int most_columns = 10;
    struct Block {
        Eigen::Matrix<double, most_columns, most_columns, Eigen::RowMajor> gram;
        double weight = 0, trimmed = 0, whole = 0, coverage = 0;
        std::array<double, 4> ground{};  // offset, gain, plane
        double variance = 0;
        bool used = false;
        Eigen::Matrix4d normal;
        Eigen::Vector4d score;
        BlockHabit habit;
        std::array<double, 2> own_slope{};
    };
    struct Pass {
        Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
        Eigen::Vector4d score = Eigen::Vector4d::Zero();
        double weight = 0, variance = 0;
    };

    template <std::size_t nuisances>
    Pass run(const Outline& at, double reach, bool trim);
    template <std::size_t nuisances>
    void accumulate(const Outline& at, double reach, bool trim);
    template <std::size_t nuisances>
    void solve_block(Block& block, const KnownSlope& slope, double spread_lost) const;
    void choose_blocks();
    void summarise(EdgeFitResult& result) const;

    bool upright_;
    std::vector<EdgeSample> samples_;
    std::vector<Block> blocks_;
    std::vector<KnownSlope> slopes_;
    std::vector<double> sorted_;
    double variance_ = 0, scale_ = 0;  // of the residuals: now, and what weights are drawn from
    double contrast_ = 0;
};

}  // namespace shaker::tracking
