#pragma once
// WalkerLaw: dry friction, gravity and a periodic base, prepared for exact steps of a walker.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/trig_polynomial.hpp"
#include "drivers/walker/walker_setting.hpp"

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

/// Slip in one direction in closed form, and the time at which it ends. Phases theta in rad within one
/// period, [0, 2 pi]. With kappa = c/omega: e^{kappa theta} v_R(theta) = C + K(theta), where C is constant
/// during a slip and K' = e^{kappa theta} f/omega, with f = dv/dt - a_B at v_R = 0. The sign changes of f,
/// known in advance, divide every slip into monotone pieces, viscous or not; only the far ends of the pieces
/// that lead towards v_R = 0 need to be checked. Immutable.
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

/// Sign of v_R = v - v_B, or at rest on the base.
enum class Contact : std::int8_t { backward = -1, stick = 0, forward = 1 };

/// Law of motion for one setting with friction in closed form. Slip with sign s: dv/dt = g sin b - s mu_k n -
/// c (v - v_B). Stick: v = v_B, possible while |a_B - g sin b| <= mu_s n. For s = -1, and for a stick that
/// would end in backward slip, both mu are multiplied by friction.backward. When v_R reaches 0 the walker
/// sticks if that is possible (for mu_s > mu_k it could also pass through; stick is chosen), else it slips
/// with the sign -sgn(a_B - g sin b). Immutable.
class WalkerLaw {
public:
    /// Throws InputError as checked() does, and for friction without a closed form. The change of mu from
    /// period to period is not part of the law.
    explicit WalkerLaw(const WalkerSetting& setting);

    /// An interval of phases with the same contact after v_R = 0: stick, or the sign of the following slip.
    struct Zone {
        double from;  // rad
        double to;
        Contact contact;
        // At `to`, for a release into the next zone:
        double v_base_to;
        double x_base_to;
        double C_next;  // constant C of the following slip
    };
    /// The zone that begins at or contains a phase in [0, 2 pi), just after it.
    [[nodiscard]] const Zone& zone_after(double phase) const noexcept;
    /// The following zone; after the last one, the first.
    [[nodiscard]] const Zone& next(const Zone& zone) const noexcept;

    [[nodiscard]] const SlipLaw& slip(Contact direction) const noexcept {
        return slips_[direction == Contact::forward ? 1 : 0];
    }
    [[nodiscard]] double v_base(double phase) const noexcept { return v_base_(phase); }  // m/s, zero mean
    [[nodiscard]] double v_base(Turn z) const noexcept { return v_base_(z); }
    [[nodiscard]] double x_base(double phase) const noexcept { return x_base_(phase); }  // m, zero mean
    [[nodiscard]] double x_base(Turn z) const noexcept { return x_base_(z); }
    [[nodiscard]] double a_base(double phase) const noexcept { return a_base_(phase); }  // m/s^2
    [[nodiscard]] double v_base_at_0() const noexcept { return v_base_at_0_; }
    [[nodiscard]] double x_base_at_0() const noexcept { return x_base_at_0_; }
    [[nodiscard]] double omega() const noexcept { return two_pi * setting_.frequency; }
    [[nodiscard]] double period() const noexcept { return 1 / setting_.frequency; }
    /// gamma/omega, the scale of velocities; gamma is the sum of the amplitudes of a_B.
    [[nodiscard]] double velocity_scale() const noexcept { return a_base_.bound(0) / omega(); }
    [[nodiscard]] const WalkerSetting& setting() const noexcept { return setting_; }

private:
    void find_zones();

    WalkerSetting setting_;
    TrigPolynomial a_base_, v_base_, x_base_;
    double v_base_at_0_ = 0, x_base_at_0_ = 0;
    std::array<SlipLaw, 2> slips_;  // backward, forward
    std::vector<Zone> zones_;       // cover [0, 2 pi)
};

}  // namespace shaker::walker
