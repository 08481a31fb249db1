#pragma once
// The equations of a shaker with a walker on its table, one smooth set for each combination of contacts.
#include <array>
#include <cstddef>
#include <limits>

#include "drivers/simulated/scene.hpp"

namespace shaker {

/// Coil current (A), position and velocity of the base (m, m/s).
struct ShakerMotion {
    double current = 0;
    double x = 0;
    double v = 0;
};

/// Which contacts hold. While none changes the motion is smooth.
struct Contacts {
    bool walker = true;  // it is on the table
    int slip = 0;        // sign of v_R = walker's velocity - v; 0: the walker rides along
    int base = 1;        // sign of v where the slide rubs; 0: the slide's friction holds the base
    int stop = 0;        // side of the end stop that pushes back
};

/// Exact to rounding over any time: series in steps short against the fastest time constant. Immutable.
class ShakerLaw {
public:
    explicit ShakerLaw(const Scene& scene);

    static constexpr std::size_t terms = 13;
    /// Taylor coefficients about the start of a step.
    struct Series {
        std::array<double, terms> current{}, x{}, v{};
        std::size_t order = 0;
        [[nodiscard]] ShakerMotion at(double t) const noexcept;
        [[nodiscard]] double gain_of_v(double t) const noexcept;  // since the start, without cancellation
    };
    /// `input` is the amplifier's output: V, or A that the motion's current has already.
    [[nodiscard]] Series series(const ShakerMotion& m, const Contacts& c, double input) const noexcept;
    /// The longest step a series is good for, s; at most a sample.
    [[nodiscard]] double longest_step() const noexcept { return longest_; }
    /// One DAC sample further, contacts unchanged.
    [[nodiscard]] ShakerMotion sample_later(const ShakerMotion& m, const Contacts& c,
                                            double input) const noexcept;

    [[nodiscard]] double base_acceleration(const ShakerMotion& m, const Contacts& c) const noexcept;
    /// Of a walker that slips.
    [[nodiscard]] double walker_acceleration(int slip) const noexcept { return downhill_ - slip * grip_k_; }
    /// How far walker, base and stop are from a change, in units of their own; one happens where one of them
    /// gets below 0. `v_R` is the walker's velocity against the base.
    [[nodiscard]] std::array<double, 3> margins(const ShakerMotion& m, double v_R,
                                                const Contacts& c) const noexcept;
    /// Margins above these at both ends of a sample stay positive in between.
    [[nodiscard]] std::array<double, 3> grazes(const Contacts& c) const noexcept;
    /// A friction that has just been overcome.
    enum class Released { none, walker, base };
    /// The contacts that follow: `together` when walker and base have one velocity, `still` when the base has
    /// none. Friction holds wherever it can.
    [[nodiscard]] Contacts settled(const ShakerMotion& m, Contacts c, bool together, bool still,
                                   Released released) const noexcept;

    [[nodiscard]] bool rubs() const noexcept { return hold_ > 0; }

private:
    struct Linear {  // one sample of the linear system: motion, input and a constant force to motion
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
    double mass_;                      // of the base with the armature, kg
    double walker_mass_;               // kg
    double downhill_;                  // g sin(tilt), m/s^2
    double grip_k_;                    // mu_k g cos(tilt), m/s^2
    double grip_s_;                    // mu_s g cos(tilt)
    double hold_;                      // slide's static friction, N
    double travel_;                    // m until a stop
    double stop_time_;                 // damping over stiffness of a stop, s
    bool linear_;                      // no cubic stiffness, Bl constant
    bool current_drive_;               //
    double sample_;                    // s
    double longest_ = 0;               // s
    std::size_t order_ = 0;            // of the series
    std::array<Linear, 5> samples_{};  // free or riding, without and with a stop; held
};

}  // namespace shaker
