#pragma once
// SlipLaw: slip in one direction in closed form, and the time at which it ends.
#include <cstddef>
#include <vector>

#include "drivers/trig_polynomial.hpp"

namespace shaker::walker {

/// Velocity and position of the walker, m/s and m.
struct Motion {
    double v = 0;
    double x = 0;
};

/// Forces per unit mass on a slipping walker: dv/dt = g sin b - s mu_k n(t) - c (v - v_B), with s the sign of
/// v_R = v - v_B.
struct SlipForces {
    int sign = 1;                                                // s
    double omega = two_pi;                                       // rad/s
    double mean = 0;                                             // g sin b - s mu_k g cos b, m/s^2
    double mu_k = 0;                                             //
    double viscous = 0;                                          // c, 1/s
    std::array<std::complex<double>, max_harmonics> base{};      // a_B, m/s^2
    std::array<std::complex<double>, max_harmonics> vertical{};  // a_z, m/s^2
};

/// Phases theta in rad within one period, [0, 2 pi]. With kappa = c/omega: e^{kappa theta} v_R(theta) = C +
/// K(theta), where C is constant during a slip and K' = e^{kappa theta} f/omega, with f = dv/dt - a_B at v_R
/// = 0. The sign changes of f, known in advance, divide every slip into monotone pieces, viscous or not; only
/// the far ends of the pieces that lead towards v_R = 0 need to be checked. Immutable.
class SlipLaw {
public:
    explicit SlipLaw(const SlipForces& forces);

    /// K at a phase.
    [[nodiscard]] double k_at(double phase) const noexcept { return evaluate(phase, turn(phase)).K; }
    [[nodiscard]] double k_at(double phase, Turn z) const noexcept { return evaluate(phase, z).K; }
    /// dv_R/dt at v_R = 0, m/s^2.
    [[nodiscard]] double f(double phase) const noexcept { return f_(phase); }
    /// e^{kappa theta}.
    [[nodiscard]] double growth(double phase) const noexcept {
        return kappa_ == 0 ? 1 : std::exp(kappa_ * phase);
    }
    /// Motion at phase `to` of a slip with motion `m` at phase `from` <= `to`.
    [[nodiscard]] Motion advance(Motion m, double from, double to) const noexcept;

    struct Zero {
        double phase = 0;
        Turn at;
    };
    static constexpr double never = 1e300;
    /// First v_R = 0 after `from` in this period for the slip with constant C (requires s v_R >= 0 at
    /// `from`); phase `never` without such a phase. Pieces that end before `ignore_until` are skipped.
    [[nodiscard]] Zero next_zero(double from, double C, double ignore_until) const noexcept;

private:
    struct KAndF {
        double K;
        double f;
    };
    /// A piece on which s v_R falls, with K at its end.
    struct Falling {
        double from;
        double to;
        double K_to;
        bool ends_at_seam;
    };
    struct Node {
        double K;
        double slope;  // dK/dtheta
    };

    [[nodiscard]] KAndF evaluate(double phase, Turn z) const noexcept;
    [[nodiscard]] double guess(std::size_t cell, double C, double a, double b) const noexcept;
    [[nodiscard]] Zero zero_in(double a, double b, double C) const noexcept;
    void find_falling_pieces();

    double sign_;
    double omega_;
    double kappa_;
    double mean_;
    TrigPolynomial f_;           // mean - a_B - s mu_k a_z
    TrigPolynomial K_periodic_;  // -Im sum A_q e^{iq theta} / (kappa + iq) / omega, A = a_B + s mu_k a_z
    TrigPolynomial U_;           // m/s, periodic response of v to the periodic part of the forces
    TrigPolynomial Y_;           // m, periodic response of x
    double slope_bound_ = 0;     // of f, for the error after a Newton step
    double node_spacing_ = 0;    // rad
    std::vector<Falling> falling_;
    std::vector<Node> nodes_;  // K on a uniform grid, ends included: start values for Newton's method
};

}  // namespace shaker::walker
