#pragma once
// Locator for any texture: the region of frame 0, shifted until it fits.
#include <Eigen/Core>

#include "tracking/image/region.hpp"
#include "tracking/image/texture_bank.hpp"
#include "tracking/locator.hpp"
#include "tracking/texture_search.hpp"

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
    struct Solution {
        Point shift;
        double gain = 0, variance = 0, likeness = 0, share = 0;
        Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // divided by the variance
        bool converged = false;
    };
    /// Finds gain, offset and step from the sums at one place. Returns false when these do not determine
    /// them.
    bool solve(const TextureBank::Sums& sums, Solution& s, double& offset, Eigen::Vector2d& step) const;
    Solution measure(const ImageView& image, Point start);
    void find_direction();
    void find_noise(const ImageView& image);
    bool judge(const Solution& solution, Candidate& out) const;
    /// Appends what resembles the texture at shifts in a box; tries at most so many places.
    void try_peaks(const ImageView& image, const Box& shifts, std::size_t tries, std::vector<Candidate>& out);
    [[nodiscard]] Box around(Point shift) const noexcept;

    Subject subject_;
    TextureBank bank_;
    TextureSearch search_;
    std::vector<TexturePeak> peaks_;
    std::vector<Candidate> near_;
    Point learned_;
    int climbed_ = 1;  // one block of so many leads a climb
    bool one_direction_ = false;
    double least_variance_ = 0;  // of the noise, from frame 0 alone
    Eigen::Vector2d direction_{1, 0};
    // Progress of a search that takes several pictures.
    std::size_t turn_ = 0;
    int next_tile_ = 0;
};

}  // namespace shaker::tracking
