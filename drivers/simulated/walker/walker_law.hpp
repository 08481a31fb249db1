#pragma once
// WalkerLaw: dry friction, gravity and a periodic base, prepared for exact steps of a walker.
#include <array>
#include <cstdint>
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/simulated/walker/slip_law.hpp"

namespace shaker::simulated {

/// Dry friction per unit mass: mu_k n + c |v - v_B| while slipping, up to mu_s n while sticking; n is the
/// normal force per unit mass.
struct Friction {
    double mu_k = 0.113;
    double mu_s = 0.113;  // >= mu_k
    double viscous = 0;   // c, 1/s
};

/// Drive and gravity of a walker. Normal force per unit mass: n(t) = g cos b + a_z. Gravity pulls with g sin
/// b towards +x, so a positive tilt b helps forward motion.
struct WalkerSetting {
    double frequency = 20;               // Hz
    Harmonics<Acceleration> base{};      // a_B along the shaker's axis
    Harmonics<Acceleration> vertical{};  // a_z
    double tilt = 0;                     // b, rad
    double g = paper_g;                  // m/s^2
    Friction friction{};
};

/// Sign of v_R = v - v_B, or at rest on the base.
enum class Contact : std::int8_t { backward = -1, stick = 0, forward = 1 };

/// Law of motion for one setting. Slip with sign s: dv/dt = g sin b - s mu_k n - c (v - v_B). Stick: v = v_B,
/// possible while |a_B - g sin b| <= mu_s n. When v_R reaches 0 the walker sticks if that is possible (for
/// mu_s > mu_k it could also pass through; stick is chosen), else it slips with the sign -sgn(a_B - g sin b).
/// Immutable.
class WalkerLaw {
public:
    /// Throws InputError that names the error: frequency, g, friction or tilt out of range, non-finite
    /// values, or a walker that leaves the base (n <= 0, with the smallest n and its phase).
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

}  // namespace shaker::simulated
