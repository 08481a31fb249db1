#include "daemon/law/least_squares.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/QR>
#include <cmath>

namespace shaker::law {

bool misfits(double chi2, int freedom) {
    return freedom >= 1 && chi2 > freedom + 5 * std::sqrt(2.0 * freedom);
}

std::string misfit(double chi2, int freedom, const std::string& what) {
    if (!misfits(chi2, freedom)) return {};
    return fmt::format("chi^2 is {:.3g} times its degrees of freedom: {}", chi2 / freedom, what);
}

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
