#pragma once
// First-order change of a settled cycle when the law or the base changes.
#include "daemon/law/pushed_walker.hpp"

namespace shaker::law {

/// A small change of the law and of the measured base.
struct Change {
    double mu = 0, tilt = 0;         // 1, rad
    double push = 0;                 // of m/M_eff
    double gravity = 0;              // m/s^2
    Harmonics<Acceleration> base{};  // m/s^2
};

/// Derivatives of v_D at one cycle. A walker in slip keeps an offset of its velocity; at an event at phase e
/// the offset becomes that of v_B there, shared by the slopes of v_R before and after; in stick it is that of
/// v_B. So every derivative follows from the events of the cycle, without a second solution. Exact to first
/// order, with the change of the push that the change causes (pushed_walker.hpp); wrong where the cycle
/// changes its kind (a stick appears), as v_D has a kink there.
class Sensitivity {
public:
    Sensitivity(const PushedCycle& cycle, double frequency, const Coulomb& law);
    /// Change of v_D in m/s.
    [[nodiscard]] double operator()(const Change& change) const;
    /// Derivatives with respect to the real and imaginary part of each measured harmonic, m/s per m/s^2:
    /// real parts of the result belong to Re a_q, imaginary parts to Im a_q. The change of the push is left
    /// out, up to a tenth of them.
    [[nodiscard]] Amplitudes by_base() const;

    /// Derivative with respect to the drag, m/s: what the damping of the base makes of the push above
    /// harmonic 16.
    [[nodiscard]] double by_drag() const;

private:
    struct Moved {
        double v_D = 0;
        Amplitudes walker{};  // change of the harmonics of a_w
    };
    [[nodiscard]] Moved moved(const Harmonics<Acceleration>& free, const std::array<double, 2>& a_w,
                              double push) const;
    double offset_after(const std::vector<double>& v_base, const std::array<double, 2>& slip, double offset,
                        std::vector<double>* at, std::vector<double>* shift) const;

    [[nodiscard]] double drift_of(const std::vector<double>& v_base, const std::vector<double>& x_base,
                                  const std::array<double, 2>& slip, std::vector<double>* shift) const;

    const PushedCycle* cycle_;
    double omega_;
    Coulomb law_;
    std::array<double, 2> slip_;     // m/s^2, of v on the free base: (1 + r) a_w
    std::vector<double> a_base_;     // of the free base at each event
    std::vector<Amplitudes> turns_;  // e^{i q theta} at each event
};

}  // namespace shaker::law
