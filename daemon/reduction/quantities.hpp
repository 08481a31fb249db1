#pragma once
// The quantities of a measurement that are one value with an error, as every door names and shows them.
// To add one: a member of Reduction, its value in reduce(), a row here, and its two columns in
// recording/tables/reduction_tables.cpp.
#include <array>
#include <numbers>
#include <string_view>

#include "daemon/reduction/reduction.hpp"

namespace shaker::reduction {

struct Quantity {
    std::string_view name;    // in JSON, before the unit: "v_D"
    std::string_view suffix;  // of the name, its unit: "_mps"
    std::string_view unit;    // SI, "m/s"; "1" for a ratio
    std::string_view shown;   // unit for the operator
    double scale;             // shown value over the value in SI units
    std::string_view words;   // of its line for the operator; empty: it has none
    calibration::Estimate (*of)(const Reduction&);
    double (*systematic)(const Reduction&) = nullptr;  // standard error by the calibrations; null: none
    std::string_view header{};                         // SCPI query of value and standard error; empty: none
    bool when_known = false;                           // no line for a value that is not determined
    bool checks = false;                               // compares instruments; not a result by itself

    [[nodiscard]] constexpr Quantity with(double (*errors)(const Reduction&)) const {
        Quantity q = *this;
        q.systematic = errors;
        return q;
    }
    [[nodiscard]] constexpr Quantity query(std::string_view scpi) const {
        Quantity q = *this;
        q.header = scpi;
        return q;
    }
    [[nodiscard]] constexpr Quantity if_known() const {
        Quantity q = *this;
        q.when_known = true;
        return q;
    }
    [[nodiscard]] constexpr Quantity check() const {
        Quantity q = *this;
        q.checks = true;
        return q;
    }
};

template <auto Member>
constexpr Quantity measured(std::string_view name, std::string_view suffix, std::string_view unit,
                            std::string_view shown, double scale, std::string_view words) {
    return {name, suffix, unit, shown, scale, words, [](const Reduction& r) { return r.*Member; }};
}
template <auto Member>
double by_calibration(const Reduction& r) {
    return r.systematic.*Member;
}

/// In the order of their lines. bench_check: acceleration of the base by the cameras over that by the
/// accelerometer. phi_off and accelerometer_corner: as Corner. delay: time of the accelerometer minus master
/// time in the middle of the measurement.
inline constexpr std::array quantities{
    measured<&Reduction::v_D>("v_D", "_mps", "m/s", "mm/s", 1e3, "v_D")
        .with(by_calibration<&Systematic::v_D>),
    measured<&Reduction::v_D_settled>("v_D_settled", "_mps", "m/s", "mm/s", 1e3, "v_D, settled").if_known(),
    measured<&Reduction::D>("D", "_m", "m", "mm a period", 1e3, "D").with(by_calibration<&Systematic::D>),
    measured<&Reduction::efficiency>("efficiency", "", "1", "", 1, "efficiency")
        .with(by_calibration<&Systematic::efficiency>)
        .query("FETCh:EFFiciency"),
    measured<&Reduction::frequency>("frequency", "_hz", "Hz", "Hz", 1, "frequency"),
    measured<&Reduction::gamma>("gamma", "_mps2", "m/s^2", "m/s^2", 1, "gamma")
        .with(by_calibration<&Systematic::gamma>)
        .query("FETCh:ACCeleration:GAMMa"),
    measured<&Reduction::rho>("rho", "", "1", "", 1, "rho"),
    measured<&Reduction::phi>("phi", "_rad", "rad", "deg", 180 / std::numbers::pi, "phi")
        .with(by_calibration<&Systematic::phi>)
        .query("FETCh:ACCeleration:PHASe"),
    measured<&Reduction::v_rms>("V_RMS", "_mps", "m/s", "mm/s", 1e3, "V_RMS")
        .with(by_calibration<&Systematic::v_rms>),
    Quantity{"bench_check", "", "1", "", 1, "camera / accelerometer",
             [](const Reduction& r) { return r.gain_ratio.ratio; }}
        .with([](const Reduction& r) { return r.gain_ratio.systematic; })
        .check(),
    Quantity{"phi_off", "_rad", "rad", "mrad", 1e3, "phi, camera - accel.",
             [](const Reduction& r) { return r.corner.phi_off; }}
        .query("FETCh:CHECk:PHASe")
        .if_known()
        .check(),
    Quantity{"accelerometer_corner", "_hz", "Hz", "Hz", 1, "accelerometer corner",
             [](const Reduction& r) { return r.corner.hz; }}
        .query("FETCh:CHECk:CORNer")
        .if_known()
        .check(),
    measured<&Reduction::accelerometer_late_s>("accelerometer_late", "_s", "s", "ms", 1e3, "").check(),
    measured<&Reduction::delay_s>("delay", "_s", "s", "ms", 1e3, "accelerometer late").check(),
    measured<&Reduction::accelerometer_ppm>("accelerometer_ppm", "", "1e-6", "ppm", 1, "accelerometer clock")
        .check()};

/// The quantity of a name. A name that is not in the table does not compile.
consteval const Quantity& quantity(std::string_view name) {
    for (const Quantity& q : quantities)
        if (q.name == name) return q;
    throw "no such quantity";
}

}  // namespace shaker::reduction
