#pragma once
// Unknowns and residuals of plane_fit.
#include <Eigen/Dense>
#include <span>
#include <vector>

#include "calibration/camera/plane_fit.hpp"

namespace shaker::calibration {

/// Unknowns: camera_unknowns of the camera, the logarithm of the board's length over its nominal one, the
/// error of each height in mm, then a, b in mm and the angle of each picture.
class PlaneModel {
public:
    static constexpr int camera_unknowns = 8;  // ln scale, ln distance, two tilts, two of the centre, k1, k2
    PlaneModel(std::span<const PlacedBoard> pictures, const optics::Board& board,
               const BoardKnowledge& known);

    struct Prior {
        int unknown;
        double mean, sigma;
    };
    struct Observation {
        std::size_t picture;
        SeenCorner corner;
        bool used = true;
    };
    /// Normal equations of the observations in use, divided by their variance, and of the priors.
    struct Normal {
        Eigen::MatrixXd matrix;
        Eigen::VectorXd gradient;
        double cost = 0;
        double squares_px = 0;
        int count = 0;  // coordinates
    };

    [[nodiscard]] const Eigen::VectorXd& start() const { return start_; }
    [[nodiscard]] View view_of(const Eigen::VectorXd& x) const;
    [[nodiscard]] optics::BoardPose pose_of(const Eigen::VectorXd& x, std::size_t picture) const;
    [[nodiscard]] Eigen::Vector2d residual(const Eigen::VectorXd& x, const Observation& o) const;
    [[nodiscard]] Normal normal(const Eigen::VectorXd& x, double noise_px) const;
    [[nodiscard]] double cost(const Eigen::VectorXd& x, double noise_px) const;
    [[nodiscard]] int first_of_pose(std::size_t picture) const;
    [[nodiscard]] bool telecentric() const { return known_.settings.distance_mm <= 0; }

    /// Corrects the observations for the bend of the squares' edges by the lens: a corner is where straight
    /// lines along them cross, which the mean sagitta moves.
    void correct_bends(const Eigen::VectorXd& x);

    std::vector<Observation> observations{};

private:
    [[nodiscard]] int level_of(std::size_t picture) const;
    void begin();

    std::span<const PlacedBoard> pictures_;
    optics::Board board_;
    BoardKnowledge known_;
    std::vector<double> levels_{};  // heights, each once
    std::vector<Prior> priors_{};
    Eigen::VectorXd start_{};
};

}  // namespace shaker::calibration
