#include "daemon/law/least_squares.hpp"

#include <Eigen/QR>

namespace shaker::law {

Linear least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& y, const Eigen::VectorXd& sigma,
                     Weights weights) {
    const Eigen::VectorXd w =
        weights == Weights::equal ? Eigen::VectorXd::Ones(y.size()) : sigma.cwiseInverse().eval();
    Linear fit;
    fit.gain = (w.asDiagonal() * A).completeOrthogonalDecomposition().pseudoInverse() * w.asDiagonal();
    fit.x = fit.gain * y;
    fit.covariance = fit.gain * sigma.cwiseAbs2().asDiagonal() * fit.gain.transpose();
    fit.residuals = y - A * fit.x;
    fit.chi2 = fit.residuals.cwiseQuotient(sigma).squaredNorm();
    fit.freedom = static_cast<int>(y.size() - A.cols());
    return fit;
}

}  // namespace shaker::law
