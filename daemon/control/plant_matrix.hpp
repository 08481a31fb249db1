#pragma once
// PlantMatrix: change of the base's harmonics for a change of the drive's, as a real 2K x 2K matrix. A
// nonlinear plant couples harmonics and treats real and imaginary parts differently.
#include <complex>
#include <memory>

#include "drivers/drive.hpp"

namespace shaker::control {

class PlantMatrix {
public:
    /// Diagonal matrix from a response per harmonic (m/s^2 per V), without coupling. harmonics: K,
    /// 1..16.
    PlantMatrix(int harmonics, const std::array<std::complex<double>, max_harmonics>& response);
    PlantMatrix(const PlantMatrix& other);
    PlantMatrix& operator=(const PlantMatrix& other);
    ~PlantMatrix();

    /// P dV: the change of motion for a change of the drive.
    [[nodiscard]] Harmonics<Acceleration> motion(const Harmonics<Voltage>& volts) const;
    /// P^+ dY: the change of the drive for a change of motion. Each harmonic is scaled by its first
    /// response; directions with a singular value below a thousandth of the largest are left out,
    /// because noise in them would become volts.
    [[nodiscard]] Harmonics<Voltage> drive(const Harmonics<Acceleration>& motion) const;
    /// Harmonic q of the motion becomes factors[q - 1] times what it was.
    void scale(const std::array<std::complex<double>, max_harmonics>& factors);
    /// Updates P from a step of the drive and the change of motion after it. First applies a common
    /// complex gain if it explains most of the change (returned; else 1), then Broyden's smallest
    /// change of P that reproduces the step. noise: sd of one part of an amplitude in `moved`;
    /// changes within it are ignored.
    std::complex<double> learn(const Harmonics<Voltage>& stepped, const Harmonics<Acceleration>& moved,
                               double noise);

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

/// Root of the sum of |a_q|^2, q = 1..K.
template <class Unit>
double norm(const Harmonics<Unit>& h, int harmonics) {
    double sum = 0;
    for (int q = 1; q <= harmonics; ++q) sum += std::norm(h.at(q));
    return std::sqrt(sum);
}

}  // namespace shaker::control
