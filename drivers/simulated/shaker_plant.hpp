#pragma once
// Voltage in, base and walker motion out: an electrodynamic shaker with a walker that sticks and slips on its
// table and pushes back on it. Event-driven: stick and slip begin at exact instants inside a sample.
#include <array>

#include "drivers/simulated/scene.hpp"

namespace shaker {

/// Mechanical and electrical state at one instant, SI.
struct PlantState {
    double current = 0;          // A in the coil
    double x = 0, v = 0, a = 0;  // base
    double walker_x = 0, walker_v = 0;
    int slip = 0;  // sign of v_R = walker_v - v; 0 while it sticks
};

class ShakerPlant {
public:
    explicit ShakerPlant(const Scene& scene);
    /// Advances by one DAC sample with `volts` held at the DAC's output.
    void step(double volts);
    [[nodiscard]] const PlantState& state() const noexcept { return state_; }
    /// Stick and slip changes so far.
    [[nodiscard]] long events() const noexcept { return events_; }

    /// Complex amplitude of the base's acceleration a volt of DAC output at a frequency, with the walker left
    /// out and without clipping: real and imaginary part, m/s^2 per V.
    static std::array<double, 2> response(const Scene& scene, double frequency);

private:
    using Vector = std::array<double, 3>;  // current, x, v
    [[nodiscard]] Vector derivative(const Vector& s, int slip) const noexcept;
    [[nodiscard]] Vector advanced(const Vector& s, int slip, double t) const noexcept;
    [[nodiscard]] double walker_acceleration(int slip) const noexcept;
    [[nodiscard]] int contact(const Vector& s) const noexcept;
    [[nodiscard]] double until_change(const Vector& s, double walker_v, int slip, double left) const;

    ShakerTruth p_;
    WalkerTruth w_;
    double h_;                                // s a sample
    double downhill_;                         // g sin(tilt)
    double normal_;                           // g cos(tilt)
    std::array<double, 2> high_pass_{};       // states
    std::array<double, 2> high_pass_gain_{};  // share of the way a state goes in a sample
    double volts_ = 0;                        // at the coil
    PlantState state_;
    long events_ = 0;
};

}  // namespace shaker
