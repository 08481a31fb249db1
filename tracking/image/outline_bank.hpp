#pragma once
// Matched filters for an outline of known size and blur, at every sub-pixel place: the fast fit of a target
// that looks as it did.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "tracking/image/edge_fit.hpp"
#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// The model of EdgeFit with size and blur known, linear in the grey levels: for each place on a grid of 1/8
/// px the derivatives of the outline, without what gain, offset and plane of a block explain, are tabulated
/// as weights of raw pixels. A step is four sums of products over the pixels; two steps lead from a
/// prediction to the place. Between places of the grid the linear model errs by less than 4e-5 px for a blur
/// of 0.76 px. Weights of a block are computed when it is first seen at a place; nothing is allocated after
/// shape().
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
        double level = 0;  // grey level between inside and outside
    };

    /// Sites are in the order of their blocks. shifts: of the blocks' centres from the common centre, px.
    void shape(const Shape& shape, std::vector<Site> sites, const std::vector<Point>& shifts);
    /// As EdgeFit::fit(), without its care for single pixels: `trimmed` is the share of pixels in blocks that
    /// do not fit. Not converged when the target is not within about 2 px of `start`.
    EdgeFitResult fit(const ImageView& image, Point start);
    /// As EdgeFit::accept().
    void accept();
    [[nodiscard]] double blur() const noexcept { return shape_.blur; }
    /// Another blur, with the same pixels.
    void set_blur(double blur) noexcept;

private:
    static constexpr int phases = 8;  // a pixel
    static constexpr int most_steps = 5;
    using Weights = std::array<float, 4>;  // of E, d/dx, d/dy, d/dsize
    struct Block {                         // at one place of the grid
        Eigen::Matrix4d ground;            // inverse of the normal equations of 1, E [, u, v]
        Eigen::Matrix3d normal;            // of x, y, size
        double outline = 0;                // sum of dE/dr
        bool known = false;
    };
    struct Range {
        int begin = 0, end = 0;              // sites
        int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // of its pixels, both ends included
        Point shift;
    };
    struct Seen {  // a block in a picture
        double gain = 0, variance = 0, freedom = 0;
        Eigen::Vector3d score;
        bool used = false;
        double off = 0;  // px, of its outline outwards from the common one
        double habit = 0, habit_frames = 0;
    };

    void learn(std::size_t place, std::size_t block, Point offset);
    template <class T>
    void look(const Pixels<T>& pixels, std::size_t place, Point offset, int x, int y, int width, int height);
    [[nodiscard]] const Block& block_at(std::size_t place, std::size_t block) const {
        return blocks_[place * ranges_.size() + block];
    }
    void choose_blocks();
    double disagreement(std::size_t place, const Eigen::Vector3d& change, double variance);
    double median_of(double Seen::*member);

    Shape shape_;
    std::vector<Site> sites_;
    std::vector<Range> ranges_;
    // For each place of the grid: one a block, and one a site. Memory of weights is touched when they are
    // computed.
    std::vector<Block> blocks_;
    std::unique_ptr<Weights[]> weights_;
    std::vector<Seen> seen_;
    std::vector<double> sorted_;
    std::vector<std::array<double, 8>> columns_;  // of a block, while its weights are computed
    double contrast_ = 0;
};

}  // namespace shaker::tracking
