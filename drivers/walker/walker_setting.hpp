#pragma once
// WalkerSetting: drive, gravity and friction of a walker.
#include "drivers/drive.hpp"
#include "drivers/trig_polynomial.hpp"
#include "drivers/walker/friction.hpp"

namespace shaker::walker {

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

/// A level walker with one coefficient of friction.
inline WalkerSetting coulomb(const Drive& drive, double mu, double g) {
    return {.frequency = drive.frequency, .base = harmonics(drive), .g = g, .friction = {mu, mu, 0}};
}

/// The setting. Throws InputError that names the error: frequency, g, friction or tilt out of range,
/// non-finite values, or a walker that leaves the base (n <= 0, with the smallest n and its phase).
WalkerSetting checked(const WalkerSetting& setting);

/// v_B(omega t), m/s.
TrigPolynomial base_velocity(const WalkerSetting& setting);

}  // namespace shaker::walker
