#pragma once
// What moves a walker on a periodic base: the drive, gravity and dry friction, ready for exact stepping.
#include <array>
#include <cstdint>
#include <vector>

#include "drivers/drive.hpp"
#include "drivers/simulated/slip_law.hpp"

namespace shaker {

/// Dry friction: |force| = mu_k n while slipping, up to mu_s n while sticking, plus c (v - v_B) while
/// slipping.
struct Friction {
    double mu_k = 0.113;
    double mu_s = 0.113;  // >= mu_k
    double viscous = 0;   // c, 1/s
};

/// The walker's surroundings. n(t) = g cos b + a_z is the normal force a unit mass; gravity pulls with g sin
/// b towards +x, so a positive tilt helps forward.
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

/// The walker's law for one setting. Stick is allowed while |a_B - g sin b| <= mu_s n. Where v_R reaches 0
/// the walker sticks wherever that is allowed (for mu_s > mu_k it could also pass through: stick wins), else
/// it slips with the sign -sgn(a_B - g sin b). Immutable.
class WalkerLaw {
public:
    /// Throws InputError naming what is wrong: a frequency, g, friction or tilt out of range, values that are
    /// not finite, or a walker that leaves the base (n <= 0, with the smallest n and its phase).
    explicit WalkerLaw(const WalkerSetting& setting);

    /// A stretch of phases with one answer to "what if v_R = 0": stick, or the sign of the slip that follows.
    struct Zone {
        double from;  // rad
        double to;
        Contact contact;
        // At `to`, for a release into the next zone:
        double v_base_to;
        double x_base_to;
        double C_next;  // of the slip that follows
    };
    /// The zone just after a phase in [0, 2 pi).
    [[nodiscard]] const Zone& zone_after(double phase) const noexcept;
    /// The zone that follows; the first one after the last.
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
    /// gamma/omega, the scale of velocities, with gamma the sum of the amplitudes of a_B.
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

}  // namespace shaker
