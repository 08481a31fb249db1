#pragma once
// ShakerPlant: DAC volts to motion of base and walker. An electrodynamic shaker with a walker that sticks and
// slips on its table and reacts on it. Event-driven: stick, slip and stops begin at exact times within a
// sample.
#include <array>

#include "drivers/simulated/shaker_law.hpp"
#include "drivers/simulated/walker_friction.hpp"

namespace shaker::simulated {

/// Mechanical and electrical state at one instant, SI.
struct PlantState {
    double current = 0;          // A in the coil
    double x = 0, v = 0, a = 0;  // base
    double walker_x = 0, walker_v = 0;
    int slip = 0;       // sign of v_R = walker_v - v; 0 while the walker sticks (never with law dahl)
    bool held = false;  // the friction of the slide holds the base
    int stop = 0;       // side of the end stop in contact; 0: none
};

class ShakerPlant {
public:
    explicit ShakerPlant(const Scene& scene);
    /// Advances by one DAC sample with `volts` held at the DAC's output.
    void step(double volts);
    [[nodiscard]] const PlantState& state() const noexcept { return state_; }
    /// Number of changes of any contact.
    [[nodiscard]] long events() const noexcept { return events_; }
    /// Output of the amplifier in the last sample: V, or A with current drive.
    [[nodiscard]] double amplifier_output() const noexcept { return output_; }

    /// Multiplies the scene's amplifier gain (with its drift) from the next sample on.
    void set_gain_factor(double factor) noexcept { gain_factor_ = factor; }
    /// Takes the walker off the table, or puts it back at its old place, at rest relative to the base.
    void set_walker(bool on_table) noexcept;
    /// Puts the walker in the middle of the base, at rest relative to it.
    void put_walker_back() noexcept;
    [[nodiscard]] bool has_walker() const noexcept { return contacts_.walker; }

    /// Complex response of the base's acceleration, real and imaginary part, m/s^2 per V of DAC output, at a
    /// frequency in Hz. Small signals, without walker, friction and stops.
    static std::array<double, 2> response(const Scene& scene, double frequency);

private:
    [[nodiscard]] double amplified(double volts) noexcept;
    void change_grip();
    [[nodiscard]] bool unchanged_sample();
    [[nodiscard]] bool is_near(const std::array<double, 3>& margins) const noexcept;
    double advance(double most, bool may_change);
    void change(std::size_t contact);
    void move_walker(const ShakerMotion& end, double t) noexcept;

    ShakerTruth p_;
    ShakerLaw law_;
    WalkerFriction friction_;
    double h_;                                // s per sample
    std::array<double, 2> high_pass_{};       // states
    std::array<double, 2> high_pass_gain_{};  // relative step of a state towards its input per sample
    std::array<double, 2> high_pass_mean_{};  // mean over a sample of an output that starts at 1
    double gain_factor_ = 1;
    double gain_growth_ = 0;  // relative growth per sample
    long samples_ = 0;
    double output_ = 0;
    ShakerMotion motion_;
    Contacts contacts_;
    bool near_ = true;  // a contact may have been close to a change at the end of the last sample
    PlantState state_;
    long events_ = 0;
};

}  // namespace shaker::simulated
