#pragma once
// Friction: the laws of friction between walker and base, with their parameters.
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace shaker::walker {

/// Friction per unit mass is mu_k n b r + c v_R against v_R = v - v_B, with n the normal force per unit mass
/// and s the sign of v_R. b is 1 for s = 1 and `backward` for s = -1. The laws differ in r:
///   coulomb      r = s. Amontons and Coulomb, 1785.
///   logarithmic  r = s (1 + B ln(1 + |v_R|/v_0)). Velocity strengthening of dry contacts: Baumberger and
///                Caroli, Adv. Phys. 55, 279 (2006), with a cut-off at v_0.
///   stribeck     r = s h(v_R), h = 1 + (mu_s/mu_k - 1) exp(-(v_R/v_s)^2): Stribeck's weakening, in the form
///                of Bo and Pavelescu, Wear 82, 277 (1982).
///   dahl         r = zeta; dzeta/dx_R = (1 - s zeta)/s_0, a contact that yields elastically over s_0
///                before it slides: Dahl, Aerospace Corp. TOR-0158(3107-18)-1 (1968), exponent 1.
///   lugre        r = zeta + tau dzeta/dt; dzeta/dt = (v_R - |v_R| zeta/h)/s_0 with the Stribeck curve
///                h of stribeck: Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans. Autom. Control
///                40, 419 (1995).
/// coulomb, logarithmic and stribeck stick: up to mu_s n b while v_R = 0. dahl and lugre have no exact stick;
/// with b their zeta tends to s b. For s_0 -> 0 (dahl, and lugre with tau = 0), B -> 0 and v_s -> 0 all
/// become Coulomb's law.
enum class FrictionLaw : std::uint8_t { coulomb, logarithmic, dahl, stribeck, lugre };
inline constexpr std::array<std::string_view, 5> friction_laws{"coulomb", "logarithmic", "dahl", "stribeck",
                                                               "lugre"};

/// Change of mu from period to period. mu_k and mu_s are multiplied by (1 + relaxation e^{-t/relaxation_s})
/// (1 + jitter z_k) with t and z_k of the start of period k; z_k = memory z_{k-1} + sqrt(1 - memory^2) n_k,
/// n_k independent and normal with standard deviation 1 (first-order autoregressive). The second factor is
/// at least 0.1.
struct MuChange {
    double jitter = 0;         // standard deviation of mu as a share of mu, 0..0.3
    double memory = 0;         // correlation between successive periods, 0..0.9999
    double relaxation = 0;     // excess of mu at t = 0 as a share of its final value, -0.9..10
    double relaxation_s = 10;  // s
    std::uint64_t seed = 1;
    [[nodiscard]] bool none() const noexcept { return jitter == 0 && relaxation == 0; }
};

/// mu as a function of the place on the base: mu_k and mu_s are multiplied by 1 + R(x_R), R a sum of eight
/// cosines with wavelengths between length/2 and 2 length and phases from `seed`; never below 0.2.
struct Roughness {
    double share = 0;      // rms of R, 0..0.2
    double length = 5e-3;  // m
    std::uint64_t seed = 1;
};

struct Friction {
    double mu_k = 0.113;
    double mu_s = 0.113;  // >= mu_k
    double viscous = 0;   // c, 1/s
    double backward = 1;  // b of backward slip: mu_k and mu_s of backward slip over those of forward slip
    FrictionLaw law = FrictionLaw::coulomb;
    double log_share = 0.1;      // B of law logarithmic
    double log_velocity = 1e-3;  // v_0 of law logarithmic, m/s
    double presliding = 7.2e-6;  // s_0 of laws dahl and lugre, m
    double stribeck = 5e-3;      // v_s of laws stribeck and lugre, m/s
    double bristle_time = 1e-4;  // tau of law lugre, s
    double ageing = 0;           // mu_s grows by this share of itself per factor e of the time at rest:
    double ageing_s = 1e-3;      // 1 + ageing ln(1 + t_rest/ageing_s); Dieterich, JGR 77, 3690 (1972)
    Roughness roughness{};
    MuChange change{};

    [[nodiscard]] double share(int sign) const noexcept { return sign < 0 ? backward : 1; }
    [[nodiscard]] bool sticks() const noexcept {
        return law != FrictionLaw::dahl && law != FrictionLaw::lugre;
    }
    /// |r|/b in steady slip at a speed |v_R|, m/s. Smooth at 0 and continued below, where no walker is.
    [[nodiscard]] double at_speed(double speed) const noexcept;
    /// True if slip has a closed form: WalkerLaw and Walker are then exact.
    [[nodiscard]] bool closed_form() const noexcept {
        return law == FrictionLaw::coulomb && ageing == 0 && roughness.share == 0;
    }
};

/// Throws InputError that names a parameter out of its range. frequency: of the drive, Hz.
void check(const Friction& friction, double frequency);

/// Throws InputError "WHAT is VALUE; must be ALLOWED" unless good.
void require(bool good, const char* what, double value, const std::string& allowed);

/// 1 + R(x) of Roughness. Immutable.
class RoughSurface {
public:
    explicit RoughSurface(const Roughness& roughness);
    /// Factor of mu at a place on the base, m.
    [[nodiscard]] double factor(double place) const noexcept;

private:
    struct Wave {
        double number;  // rad/m
        double phase;   // rad
    };
    static constexpr std::size_t waves = 8;
    double amplitude_;  // of each wave
    std::array<Wave, waves> waves_{};
};

/// Factors of mu_k and mu_s in successive periods, as MuChange defines them. Equal settings give equal
/// factors.
class MuHistory {
public:
    /// period: time between two factors, s.
    MuHistory(const MuChange& change, double period);
    /// The factor of the next period; the first call gives that of period 0.
    double next();

private:
    MuChange change_;
    double period_;
    double renewal_;  // sqrt(1 - memory^2)
    std::mt19937_64 random_;
    std::normal_distribution<double> normal_;
    double z_ = 0;
    double k_ = 0;  // periods so far
};

}  // namespace shaker::walker
