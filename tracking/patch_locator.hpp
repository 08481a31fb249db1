#pragma once
// Locator for any texture: the region of frame 0, shifted until it fits.
#include <Eigen/Core>

#include "tracking/image/region.hpp"
#include "tracking/image/texture.hpp"
#include "tracking/locator.hpp"

namespace shaker::tracking {

/// Least squares of shift, gain and offset between raw pixels and the shifted texture T of frame 0: I(p) =
/// offset + gain T(p - shift). Blocks of 8 x 8 px that do not fit (hidden, reflecting) are excluded. A
/// texture that varies in one direction only is measured along it; the other coordinate stays at its value in
/// frame 0.
class PatchLocator final : public Locator {
public:
    explicit PatchLocator(Subject subject) : subject_{std::move(subject)} {}
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 8; }
    [[nodiscard]] double extent() const noexcept override;
    [[nodiscard]] bool interchangeable() const noexcept override { return true; }

private:
    struct Sums;
    struct Solution {
        Point shift;
        double gain = 0, variance = 0, likeness = 0, share = 0;
        Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // divided by the variance
        bool converged = false;
    };
    Solution measure(const ImageView& image, Point shift);
    template <class P>
    void accumulate(const P& pixels, const Box& cut, int x0, int y0, Sums& sums) const;
    template <class P>
    double weigh_blocks(const P& pixels, const Box& cut, int x0, int y0, double gain, double offset);
    [[nodiscard]] std::size_t block_of(int x, int y) const noexcept;
    void find_direction();
    void find_noise(const ImageView& image);
    bool judge(const Solution& solution, Candidate& out) const;
    bool best_match(const ImageView& image, Point around, Point& shift) const;

    Subject subject_;
    Texture texture_;
    Point learned_;
    std::vector<double> block_weight_, block_residual_, block_size_, sorted_;
    int block_columns_ = 0;
    bool one_direction_ = false;
    double least_variance_ = 0;  // of the noise, from frame 0 alone
    Eigen::Vector2d direction_{1, 0};
};

}  // namespace shaker::tracking
