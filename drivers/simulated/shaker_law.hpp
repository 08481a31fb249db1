#pragma once
// ShakerLaw: equations of motion of a shaker with a walker on its table, smooth for each combination of
// contacts.
#include <array>
#include <cstddef>
#include <limits>

#include "drivers/simulated/scene.hpp"
#include "drivers/simulated/walker_friction.hpp"

namespace shaker::simulated {

/// Coil current (A), position and velocity of the base (m, m/s).
struct ShakerMotion {
    double current = 0;
    double x = 0;
    double v = 0;
};

/// State of the contacts. Between changes the motion is smooth.
struct Contacts {
    bool walker = true;  // the walker is on the table
    int slip = 0;        // sign of v_R = walker's velocity - v; 0: the walker sticks
    int base = 1;        // sign of v while the slide slips; 0: static friction holds the base
    int stop = 0;        // side of the end stop in contact; 0: none
    Grip grip{};         // friction of the walker in the present sample
};

/// Equations, with Bl(x) = Bl (1 - b x^2):
///   m dv/dt = Bl(x) i - k x - k3 x^3 - d v + F,  dx/dt = v,  L di/dt = u - R i - Bl(x) v (voltage drive).
/// F is the constant force of walker, slide and stop; m includes a walker that sticks. A stop adds stiffness
/// and damping. Solved by Taylor series in steps shorter than the fastest time constant: exact to rounding
/// over any time. Immutable.
class ShakerLaw {
public:
    explicit ShakerLaw(const Scene& scene);

    static constexpr std::size_t terms = 13;
    /// Taylor coefficients about the start of a step.
    struct Series {
        std::array<double, terms> current{}, x{}, v{};
        std::size_t order = 0;
        [[nodiscard]] ShakerMotion at(double t) const noexcept;
        [[nodiscard]] double gain_of_v(double t) const noexcept;  // v(t) - v(0) without cancellation
    };
    /// input: output of the amplifier in V; with current drive in A, equal to the motion's current.
    [[nodiscard]] Series series(const ShakerMotion& m, const Contacts& c, double input) const noexcept;
    /// The longest step for which a series is accurate, s; at most one sample.
    [[nodiscard]] double longest_step() const noexcept { return longest_; }
    /// The motion one DAC sample later with unchanged contacts.
    [[nodiscard]] ShakerMotion sample_later(const ShakerMotion& m, const Contacts& c,
                                            double input) const noexcept;

    [[nodiscard]] double base_acceleration(const ShakerMotion& m, const Contacts& c) const noexcept;
    /// Acceleration of a slipping walker, m/s^2.
    [[nodiscard]] double walker_acceleration(const Contacts& c) const noexcept {
        return downhill_ - c.slip * c.grip.kinetic(c.slip);
    }
    /// Distances of walker, base and stop from a change of contact, each in its own unit; below 0 the contact
    /// changes. v_R: velocity of the walker relative to the base, m/s.
    [[nodiscard]] std::array<double, 3> margins(const ShakerMotion& m, double v_R,
                                                const Contacts& c) const noexcept;
    /// A margin above these values at both ends of a sample stays positive between them.
    [[nodiscard]] std::array<double, 3> grazes(const Contacts& c) const noexcept;
    /// The friction that was overcome last.
    enum class Released { none, walker, base };
    /// The contacts after a change. together: walker and base have the same velocity; still: the base is at
    /// rest. Static friction holds wherever it can.
    [[nodiscard]] Contacts settled(const ShakerMotion& m, Contacts c, bool together, bool still,
                                   Released released) const noexcept;

    [[nodiscard]] bool rubs() const noexcept { return hold_ > 0; }

private:
    struct Linear {  // one sample of the linear system: response of the motion to motion, input and constant
                     // force
        std::array<ShakerMotion, 5> columns{};
    };
    [[nodiscard]] double mass(const Contacts& c) const noexcept;
    [[nodiscard]] double constant_force(const Contacts& c) const noexcept;
    [[nodiscard]] double free_force(const ShakerMotion& m, const Contacts& c) const noexcept;
    [[nodiscard]] bool possible(const ShakerMotion& m, const Contacts& c, bool together,
                                bool still) const noexcept;
    [[nodiscard]] Series series(const ShakerMotion& m, const Contacts& c, double input,
                                double force) const noexcept;
    [[nodiscard]] ShakerMotion stepped(ShakerMotion m, const Contacts& c, double input,
                                       double force) const noexcept;
    void choose_step(double rate);
    void prepare_samples();

    ShakerTruth p_;
    double mass_;         // kg, base with armature
    double walker_mass_;  // kg
    double downhill_;     // g sin(tilt), m/s^2
    double hold_;         // N, static friction of the slide
    double travel_;       // m, free travel to a stop
    double stop_time_;    // s, damping / stiffness of a stop
    bool linear_;         // no cubic stiffness and constant Bl
    bool current_drive_;
    double sample_;                    // s, length of a sample
    double longest_ = 0;               // s
    std::size_t order_ = 0;            // of the series
    std::array<Linear, 5> samples_{};  // walker slipping or sticking, without and with a stop; base held
};

}  // namespace shaker::simulated
