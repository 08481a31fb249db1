#pragma once
// DAC volts in, base and walker motion out: an electrodynamic shaker with a walker that sticks and slips on
// its table and pushes back on it. Event-driven: stick, slip and stops begin at exact instants inside a
// sample.
#include <array>

#include "drivers/simulated/shaker_law.hpp"

namespace shaker {

/// Mechanical and electrical state at one instant, SI.
struct PlantState {
    double current = 0;          // A in the coil
    double x = 0, v = 0, a = 0;  // base
    double walker_x = 0, walker_v = 0;
    int slip = 0;       // sign of v_R = walker_v - v; 0 while it sticks
    bool held = false;  // the base is, by the friction of its slide
    int stop = 0;       // side of the end stop that is touched
};

class ShakerPlant {
public:
    explicit ShakerPlant(const Scene& scene);
    /// Advances by one DAC sample with `volts` held at the DAC's output.
    void step(double volts);
    [[nodiscard]] const PlantState& state() const noexcept { return state_; }
    /// Changes of any contact so far.
    [[nodiscard]] long events() const noexcept { return events_; }
    /// What the amplifier gave in the last sample: V, or A when it drives a current.
    [[nodiscard]] double amplifier_output() const noexcept { return output_; }

    /// From the next sample on the amplifier's gain is the scene's (with its drift) times this.
    void set_gain_factor(double factor) noexcept { gain_factor_ = factor; }
    /// Takes the walker off the table, or puts it back where it was, at rest against the base.
    void set_walker(bool on_table) noexcept;
    [[nodiscard]] bool has_walker() const noexcept { return contacts_.walker; }

    /// Complex amplitude of the base's acceleration a volt of DAC output at a frequency, for small signals
    /// and without walker, friction and stops: real and imaginary part, m/s^2 per V.
    static std::array<double, 2> response(const Scene& scene, double frequency);

private:
    [[nodiscard]] double amplified(double volts) noexcept;
    [[nodiscard]] bool unchanged_sample();
    [[nodiscard]] bool is_near(const std::array<double, 3>& margins) const noexcept;
    double advance(double most, bool may_change);
    void change(std::size_t contact);
    void move_walker(const ShakerMotion& end, double t) noexcept;

    ShakerTruth p_;
    ShakerLaw law_;
    double h_;                                // s a sample
    std::array<double, 2> high_pass_{};       // states
    std::array<double, 2> high_pass_gain_{};  // share of the way a state goes in a sample
    std::array<double, 2> high_pass_mean_{};  // mean over a sample of an output that starts at 1
    double gain_factor_ = 1;
    double gain_growth_ = 0;  // of itself a sample
    long samples_ = 0;
    double output_ = 0;
    ShakerMotion motion_;
    Contacts contacts_;
    bool near_ = true;  // a change of contacts may have been near at the end of the last sample
    PlantState state_;
    long events_ = 0;
};

}  // namespace shaker
