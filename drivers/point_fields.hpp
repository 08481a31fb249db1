#pragma once
// The parameters of a measured point, one row each: plans, settings files, the command line and orders share
// the table.
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <variant>

#include "drivers/drive.hpp"

namespace shaker {

/// The measurements at a set-point.
struct MeasurementPlan {
    int periods = 40;      // of a measurement; 0: nothing is measured, the drive only moves the walker
    int settle = 0;        // periods of settled drive before it; 0: until the walker's drift is steady
    int measurements = 0;  // on call: then the drive stops or is only kept; 0: until another order
    bool operator==(const MeasurementPlan&) const = default;
};

/// One parameter of a MeasurementPlan, a whole number. Every door reads the rows: an order of a client has
/// all of them.
struct MeasurementField {
    std::string_view key;     // of an order in JSON, and of the table [run] of a settings file
    std::string_view option;  // of the command line
    std::string_view header;  // of SCPI
    std::string_view word;    // SCPI word that stands for 0; empty: 0 is not allowed
    int MeasurementPlan::*member;
    Range allowed;
    bool lasts;                  // an order that does not give it keeps the last value; false: it is then 0
    std::string_view otherwise;  // used by shakerctl when it is not given
    std::string_view help;
};

inline constexpr std::array<MeasurementField, 3> measurement_fields{{
    {"periods",
     "--periods",
     "AVERage:PERiods",
     "",
     &MeasurementPlan::periods,
     {3, 1'000'000},
     true,
     "as last",
     "Drive periods of a measurement, after settling"},
    {"settle_periods",
     "--settle",
     "AVERage:SETTle",
     "AUTO",
     &MeasurementPlan::settle,
     {0, 10'000},
     true,
     "as last",
     "Periods of the settled drive before a measurement; 0: until the walker's drift is steady"},
    {"measurements",
     "--measurements",
     "TRIGger:COUNt",
     "INFinity",
     &MeasurementPlan::measurements,
     {0, 100'000},
     false,
     "until \"shakerctl stop\"",
     "Measurements, then a soft stop; 0: until stopped"},
}};

/// A requested point: the drive, and how long it is measured.
struct PointSettings {
    Drive drive{};
    MeasurementPlan plan{};
    double precision = 0;    // m/s, standard error of v_D that ends the measurement; 0: `periods` decides
    int least_periods = 20;  // with a precision: range of the measured periods
    int most_periods = 400;
};

struct PointField {
    using Member =
        std::variant<double Drive::*, int MeasurementPlan::*, int PointSettings::*, double PointSettings::*>;
    std::string_view name;    // key of a plan
    std::string_view key;     // of the table [run] of a settings file; empty: not in there
    std::string_view option;  // of the command line; empty: no option
    Member member;
    Dimension dimension;
    Range allowed;                 // SI units; both ends included
    std::string_view standard;     // default, as a person would type it; empty: no such parameter is given
    std::string_view placeholder;  // word for it in the help
    std::string_view help;

    [[nodiscard]] constexpr bool whole() const noexcept {
        return std::holds_alternative<int MeasurementPlan::*>(member) ||
               std::holds_alternative<int PointSettings::*>(member);
    }
    [[nodiscard]] double in(const PointSettings& point) const {
        if (const auto* of_drive = std::get_if<double Drive::*>(&member)) return point.drive.**of_drive;
        if (const auto* of_plan = std::get_if<int MeasurementPlan::*>(&member)) return point.plan.**of_plan;
        if (const auto* number = std::get_if<int PointSettings::*>(&member)) return point.**number;
        return point.*std::get<double PointSettings::*>(member);
    }
    /// Sets the parameter. A whole number is rounded.
    void set(PointSettings& point, double value) const {
        if (const auto* of_drive = std::get_if<double Drive::*>(&member))
            point.drive.** of_drive = value;
        else if (const auto* of_plan = std::get_if<int MeasurementPlan::*>(&member))
            point.plan.** of_plan = static_cast<int>(std::lround(value));
        else if (const auto* number = std::get_if<int PointSettings::*>(&member))
            point.** number = static_cast<int>(std::lround(value));
        else
            point.*std::get<double PointSettings::*>(member) = value;
    }
};

constexpr PointField point_field_of(const MeasurementField& field, std::string_view name,
                                    std::string_view standard) {
    return {name,          field.key, field.option, field.member, Dimension::ratio,
            field.allowed, standard,  "N",          field.help};
}

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
    point_field_of(measurement_fields[0], "periods", "40"),
    point_field_of(measurement_fields[1], "settle", "0"),
    {"precision",
     "",
     "",
     &PointSettings::precision,
     Dimension::velocity,
     {1e-8, 1},
     "",
     "VELOCITY",
     "Standard error of v_D, of all passes combined, that ends the measurement, instead of a number of "
     "periods"},
    {"least_periods",
     "",
     "",
     &PointSettings::least_periods,
     Dimension::ratio,
     {5, measurement_fields[0].allowed.max},
     "20",
     "N",
     "Periods that are measured at least, with a precision"},
    {"most_periods",
     "",
     "",
     &PointSettings::most_periods,
     Dimension::ratio,
     {5, measurement_fields[0].allowed.max},
     "400",
     "N",
     "Periods that are measured at most, with a precision"},
}};
/// The parameter with a name of the table.
constexpr const PointField& point_field(std::string_view name) {
    return *std::ranges::find(point_fields, name, &PointField::name);
}

}  // namespace shaker
