#pragma once
// The parameters of a measured point, one row each: plans, settings files, the command line and orders share
// the table.
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <variant>

#include "drivers/drive_limits.hpp"

namespace shaker {

/// A requested point: the drive, and how long it is measured.
struct PointSettings {
    Drive drive{};
    int periods = 40;        // of a measurement
    int settle = 0;          // periods of settled drive before it; 0: until the walker's drift is steady
    double precision = 0;    // m/s, standard error of v_D that ends the measurement; 0: `periods` decides
    int least_periods = 20;  // with a precision: range of the measured periods
    int most_periods = 400;
};

struct PointField {
    using Member = std::variant<double Drive::*, int PointSettings::*, double PointSettings::*>;
    std::string_view name;    // key of a plan
    std::string_view key;     // of the table [run] of a settings file; empty: not in there
    std::string_view option;  // of the command line; empty: there is none
    Member member;
    Dimension dimension;
    Range allowed;                 // SI units; both ends included
    std::string_view standard;     // default, as a person would type it; empty: no such parameter is given
    std::string_view placeholder;  // word for it in the help
    std::string_view help;

    [[nodiscard]] constexpr bool whole() const noexcept {
        return std::holds_alternative<int PointSettings::*>(member);
    }
    [[nodiscard]] double in(const PointSettings& point) const {
        if (const auto* of_drive = std::get_if<double Drive::*>(&member)) return point.drive.**of_drive;
        if (const auto* number = std::get_if<int PointSettings::*>(&member)) return point.**number;
        return point.*std::get<double PointSettings::*>(member);
    }
    /// Sets the parameter. A whole number is rounded.
    void set(PointSettings& point, double value) const {
        if (const auto* of_drive = std::get_if<double Drive::*>(&member))
            point.drive.** of_drive = value;
        else if (const auto* number = std::get_if<int PointSettings::*>(&member))
            point.** number = static_cast<int>(std::lround(value));
        else
            point.*std::get<double PointSettings::*>(member) = value;
    }
};

/// The first four are those of a drive.
inline constexpr std::size_t drive_fields = 4;
inline constexpr std::array<PointField, 9> point_fields{{
    {"gamma", "gamma_mps2", "--gamma", &Drive::gamma, Dimension::acceleration, drive_limits.gamma, "1g",
     "ACCELERATION", "Acceleration amplitude of the base, e.g. 1.5g or 14.7m/s^2"},
    {"phi", "phi_rad", "--phi", &Drive::phi, Dimension::angle, drive_limits.phi, "0", "ANGLE",
     "Phase of the second harmonic, e.g. 35deg or 0.61rad"},
    {"rho", "rho", "--rho", &Drive::rho, Dimension::ratio, drive_limits.rho, "0.5", "SHARE",
     "Share of the first harmonic"},
    {"frequency", "frequency_hz", "--frequency", &Drive::frequency, Dimension::frequency,
     drive_limits.frequency, "20Hz", "FREQUENCY", "Frequency of the first harmonic, e.g. 20Hz"},
    {"periods",
     "periods",
     "--periods",
     &PointSettings::periods,
     Dimension::ratio,
     {2, most_periods},
     "40",
     "N",
     "Drive periods to measure after settling"},
    {"settle",
     "settle_periods",
     "--settle",
     &PointSettings::settle,
     Dimension::ratio,
     {0, most_settle_periods},
     "0",
     "N",
     "Periods of the settled drive before the measurement; 0: until the walker's drift is steady"},
    {"precision",
     "",
     "",
     &PointSettings::precision,
     Dimension::velocity,
     {1e-8, 1},
     "",
     "VELOCITY",
     "Standard error of v_D that ends the measurement, instead of a number of periods"},
    {"least_periods",
     "",
     "",
     &PointSettings::least_periods,
     Dimension::ratio,
     {5, most_periods},
     "20",
     "N",
     "Periods that are measured at least, with a precision"},
    {"most_periods",
     "",
     "",
     &PointSettings::most_periods,
     Dimension::ratio,
     {5, most_periods},
     "400",
     "N",
     "Periods that are measured at most, with a precision"},
}};
/// The parameter with a name of the table.
constexpr const PointField& point_field(std::string_view name) {
    return *std::ranges::find(point_fields, name, &PointField::name);
}

}  // namespace shaker
