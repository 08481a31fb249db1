#pragma once
// IntegratedWalker: motion of a walker under laws of friction without a closed form, by numerical integration
// from event to event.
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/walker/slip_equation.hpp"
#include "drivers/walker/walker.hpp"

namespace shaker::walker {

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
};

}  // namespace shaker::walker
