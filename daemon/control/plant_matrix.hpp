#pragma once
// How the base's harmonics answer to the drive's, every one to every other: a real 2K x 2K matrix, since a
// plant that is not linear couples harmonics and treats real and imaginary parts apart.
#include <complex>
#include <memory>

#include "drivers/drive.hpp"

namespace shaker {

class PlantMatrix {
public:
    /// From a response a harmonic (m/s^2 a volt): no coupling yet. harmonics: K, 1..16.
    PlantMatrix(int harmonics, const std::array<std::complex<double>, max_harmonics>& response);
    PlantMatrix(const PlantMatrix& other);
    PlantMatrix& operator=(const PlantMatrix& other);
    ~PlantMatrix();

    /// The change of motion that a change of the drive makes.
    [[nodiscard]] Harmonics<Acceleration> motion(const Harmonics<Voltage>& volts) const;
    /// The change of drive that makes a change of motion. Directions in which the plant hardly answers (a
    /// singular value below a thousandth of the largest, after each harmonic was scaled by its first
    /// response) get none: noise there would become volts.
    [[nodiscard]] Harmonics<Voltage> drive(const Harmonics<Acceleration>& motion) const;
    /// What a step of the drive did teaches. A common complex gain that explains most of it is taken first
    /// (returned; 1 when none was), the rest as Broyden's smallest change that makes the last step true.
    /// `noise`: sd of an amplitude's part in `moved`; what is within it teaches nothing.
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

}  // namespace shaker
