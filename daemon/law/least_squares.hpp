#pragma once
// Weighted linear least squares, for the sources of this room: the header brings Eigen.
#include <Eigen/Core>
#include <string>

namespace shaker::law {

/// y = A x with independent errors.
struct Linear {
    Eigen::VectorXd x;
    Eigen::MatrixXd gain;        // x = gain y
    Eigen::MatrixXd covariance;  // from sigma
    Eigen::VectorXd residuals;   // y - A x
    double chi2 = 0;
    int freedom = 0;
};

enum class Weights { by_error, equal };

/// Least squares. equal: every row has the same weight, for a model that does not fit to within the errors,
/// where the most exact points would decide alone; covariance and chi^2 are those of the given sigma anyway.
/// The matrix must have full column rank.
Linear least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& y, const Eigen::VectorXd& sigma,
                     Weights weights);

/// True where chi^2 exceeds its expectation by more than five of its own standard deviations.
bool misfits(double chi2, int freedom);
/// "chi^2 is 25 times its degrees of freedom: WHAT" where it misfits; empty otherwise.
std::string misfit(double chi2, int freedom, const std::string& what);

}  // namespace shaker::law
