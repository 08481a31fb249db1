#pragma once
// WalkerLaw: dry friction, gravity and a periodic base, prepared for exact steps of a walker.
#include <array>
#include <cstdint>
#include <vector>

#include "drivers/walker/slip_law.hpp"
#include "drivers/walker/walker_setting.hpp"

namespace shaker::walker {

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
