#pragma once
// IntegratedWalker: motion of a walker under laws of friction without a closed form, by numerical integration
// from event to event.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/trig_polynomial.hpp"
#include "drivers/walker/friction.hpp"
#include "drivers/walker/walker.hpp"
#include "drivers/walker/walker_setting.hpp"

namespace shaker::walker {

/// Sign of a slip, and the place and the state of the contact where it began.
struct SlipStart {
    int sign = 1;
    double u = 0;
    double zeta = 0;  // law dahl
};

/// The equation of relative motion of walker and base under any law of friction:
/// d v_R/dt = g sin b - a_B(t) - mu_k n(t) b r - c v_R, with r of FrictionLaw. Variables without unit: w =
/// v_R/V, u = omega x_R/V, theta = omega t; V = (gamma + g)/omega. During a slip the sign s of v_R is fixed,
/// so the equation is smooth across the end of the slip. Law dahl is solved for zeta: zeta(u) = s b + (zeta_0
/// - s b) exp(-s (x_R - x_0)/s_0).
class SlipEquation {
public:
    /// The setting must be checked.
    explicit SlipEquation(const WalkerSetting& setting);

    /// Multiplies mu_k and mu_s.
    void set_mu_factor(double factor) noexcept { mu_factor_ = factor; }
    /// Place on the base at u = 0, m.
    void set_place(double place) noexcept { place_ = place; }

    using Pair = std::array<double, 2>;
    using Triple = std::array<double, 3>;
    /// dw/dtheta and du/dtheta; laws coulomb, logarithmic and dahl.
    [[nodiscard]] Pair rates(double theta, double w, double u, const SlipStart& start) const noexcept;
    /// dw/dtheta, du/dtheta and dzeta/dtheta; law lugre.
    [[nodiscard]] Triple bristle_rates(double theta, const Triple& y, int sign) const noexcept;
    /// zeta of law dahl at u.
    [[nodiscard]] double dahl_zeta(double u, const SlipStart& start) const noexcept;

    /// a_B - g sin b: the acceleration that friction must give to a walker at rest on the base, m/s^2.
    [[nodiscard]] double needed(double theta) const noexcept { return a_base_(theta) - pull_; }
    /// Acceleration that static friction can give at u after a rest of this many seconds, m/s^2.
    [[nodiscard]] double holds(double theta, double u, double rest_s) const noexcept;

    [[nodiscard]] const WalkerSetting& setting() const noexcept { return setting_; }
    [[nodiscard]] double unit_velocity() const noexcept { return V_; }  // m/s
    [[nodiscard]] double omega() const noexcept { return omega_; }      // rad/s
    [[nodiscard]] double metres(double u) const noexcept { return u * V_ / omega_; }
    [[nodiscard]] int order() const noexcept { return std::max({a_base_.order, n_.order, 1}); }

private:
    [[nodiscard]] double grip(double theta, double u) const noexcept;

    WalkerSetting setting_;
    RoughSurface surface_;
    TrigPolynomial a_base_, n_;
    double pull_;   // g sin b, m/s^2
    double omega_;  // rad/s
    double V_;      // m/s
    double mu_factor_ = 1;
    double place_ = 0;
};

/// Slip: Dormand and Prince's method of fifth order with step control and dense output (Boost's odeint).
/// Every zero of v_R ends a step: it is located on the dense output, and stick or the next slip begins there
/// as in WalkerLaw. Steps are at most 1/24 of the shortest period of the drive. Law dahl is integrated
/// without its stiff variable (SlipEquation); the steps of law lugre are bounded by stability to about 3
/// s_0/|v_R|, so its cost grows as 1/s_0. (Boost 1.74's Rosenbrock method does not compile as C++20.) Stick:
/// ends where a margin evaluated at 64 instants of the shortest period becomes negative; a shorter release is
/// missed. Laws dahl and lugre have no stick: their events are the zeros of v_R.
class IntegratedWalker {
public:
    static constexpr double usual_tolerance = 1e-10;
    /// Starts at phase 0 with velocity v (m/s). tolerance: error per step of v_R, relative to (gamma +
    /// g)/omega, 1e-13..1e-2. Throws InputError as checked() does.
    explicit IntegratedWalker(const WalkerSetting& setting, double v = 0, double tolerance = usual_tolerance);

    /// Advances to the next start of a period. Returns D, m.
    double advance_period();
    /// From now on relative() holds v_R at this many uniform phases of the last period; 0: none.
    void observe(std::size_t phases) { relative_.assign(phases, 0); }
    /// v_R at phases i/n of the last period, m/s.
    [[nodiscard]] std::span<const double> relative() const noexcept { return relative_; }
    /// At a start of a period: goes on with another velocity (m/s) and, for law dahl, state of the contact.
    /// False, and nothing changes, where the walker sticks or would turn round under a law that sticks.
    bool jump_to(double v, double zeta) noexcept;
    /// State of the contact, law dahl.
    [[nodiscard]] double zeta() const noexcept { return zeta_; }
    /// Multiplies mu_k and mu_s from now on.
    void set_mu_factor(double factor) noexcept { equation_.set_mu_factor(factor); }

    [[nodiscard]] WalkerPoint now() const noexcept { return now_; }
    [[nodiscard]] std::int64_t period() const noexcept { return period_; }
    /// Events of the last period.
    [[nodiscard]] std::span<const WalkerEvent> events() const noexcept { return events_; }
    /// gamma/omega, m/s.
    [[nodiscard]] double velocity_scale() const noexcept { return scale_; }
    [[nodiscard]] const WalkerSetting& setting() const noexcept { return equation_.setting(); }

private:
    void choose_contact(double rest_s);
    void slip();
    template <class Stepper, class System, class State>
    void slip_with(Stepper stepper, System system, State state);
    template <class Speed>
    void observe_slip(double from, double to, const Speed& speed);
    void stick();
    void turn_to(Contact contact);
    [[nodiscard]] double release_after(double theta) const;

    SlipEquation equation_;
    TrigPolynomial v_base_;
    double scale_;
    double tolerance_;
    Contact contact_ = Contact::stick;
    SlipStart start_{};
    double theta_ = 0;                 // rad, 0..2 pi
    double w_ = 0, u_ = 0, zeta_ = 0;  // as in SlipEquation; u counts from the start of the period
    double step_ = 1e-3;               // rad, last step of the integrator
    double rest_from_ = 0;             // rad; negative: in an earlier period
    double x_before_ = 0, place_ = 0;  // m, of the completed periods
    WalkerPoint now_;
    std::int64_t period_ = 0;
    std::vector<WalkerEvent> events_;
    std::vector<double> relative_;
};

}  // namespace shaker::walker
