#pragma once
// WalkerFriction: the grip of the scene's walker, sample by sample.
#include <algorithm>

#include "drivers/simulated/scene.hpp"
#include "drivers/walker/friction.hpp"

namespace shaker::simulated {

/// The accelerations that friction gives a walker, constant during one sample of the plant. All in m/s^2.
/// Kinetic friction works against the slip; a law without stick gives it with its own sign and has no static
/// friction.
struct Grip {
    double forward = 0, backward = 0;            // kinetic, in forward and in backward slip
    double hold_forward = 0, hold_backward = 0;  // static, against a release into that slip

    [[nodiscard]] double kinetic(int slip) const noexcept { return slip < 0 ? backward : forward; }
    /// Static friction for the acceleration that a walker at rest on the base needs.
    [[nodiscard]] double hold(double needed) const noexcept {
        return needed > 0 ? hold_backward : hold_forward;
    }
    [[nodiscard]] double most_hold() const noexcept { return std::max(hold_forward, hold_backward); }
};

/// Motion of the walker relative to the base at the start of a sample, SI.
struct RelativeMotion {
    double x = 0, v = 0, a = 0;
    int slip = 0;  // as in Contacts
};

/// The laws of Friction, evaluated for the middle of each sample and held during it: second order in the
/// sample. Friction that does not change is exact. Jitter and relaxation of mu change at the start of steps
/// of mu_step_s. Law dahl has no stick: its grip contains the sign of zeta, and `hold` is 0.
class WalkerFriction {
public:
    explicit WalkerFriction(const Scene& scene);
    /// False if the grip is the same in all samples: dry friction alone.
    [[nodiscard]] bool varies() const noexcept { return varies_; }
    /// False for law dahl.
    [[nodiscard]] bool sticks() const noexcept { return friction_.sticks(); }
    /// The grip of the scene's mu at rest.
    [[nodiscard]] Grip standing() const noexcept { return grip_of({}, 1, 1); }
    /// The grip of the next sample; one call per sample.
    Grip next(const RelativeMotion& m);
    /// The walker was put on the base at x: the contact is new.
    void put_down(double x) noexcept;

private:
    [[nodiscard]] Grip grip_of(const RelativeMotion& middle, double mu_factor, double aged) const noexcept;
    [[nodiscard]] double zeta_after(double way) const noexcept;

    walker::Friction friction_;
    double kinetic_, hold_;  // mu_k and mu_s times g cos(tilt), m/s^2
    double sample_;          // s
    bool varies_;
    walker::MuHistory history_;
    walker::RoughSurface surface_;
    long samples_per_step_;
    long samples_ = 0;
    double mu_factor_ = 1;  // of the present step
    double rest_s_ = 0;     // time at rest on the base
    double zeta_ = 0;       // of law dahl, at the start of the sample
    double x_ = 0;          // m, at the last call
};

}  // namespace shaker::simulated
