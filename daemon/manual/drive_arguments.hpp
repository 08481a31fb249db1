#pragma once
// The options that describe a drive, for every command that takes one.
#include <array>

#include "daemon/manual/values.hpp"
#include "drivers/drive_limits.hpp"

namespace shaker::manual {

/// --gamma, --phi, --rho and --frequency. defaults: help shows the values of Drive{}, which are used for
/// options that are not given.
constexpr std::array<Argument, 4> drive_arguments(bool defaults) {
    const auto standard = [&](std::string_view text) { return defaults ? text : std::string_view{}; };
    return {{{.name = "--gamma",
              .value = "ACCELERATION",
              .help = "Acceleration amplitude of the base, e.g. 1.5g or 14.7m/s^2",
              .kind = Kind::quantity,
              .dimension = Dimension::acceleration,
              .allowed = drive_limits.gamma,
              .standard = standard("1g")},
             {.name = "--phi",
              .value = "ANGLE",
              .help = "Phase of the second harmonic, e.g. 35deg or 0.61rad",
              .kind = Kind::quantity,
              .dimension = Dimension::angle,
              .allowed = drive_limits.phi,
              .standard = standard("0")},
             {.name = "--rho",
              .value = "SHARE",
              .help = "Share of the first harmonic",
              .kind = Kind::quantity,
              .dimension = Dimension::ratio,
              .allowed = drive_limits.rho,
              .standard = standard("0.5")},
             {.name = "--frequency",
              .value = "FREQUENCY",
              .help = "Frequency of the first harmonic, e.g. 20Hz",
              .kind = Kind::quantity,
              .dimension = Dimension::frequency,
              .allowed = drive_limits.frequency,
              .standard = standard("20Hz")}}};
}

/// `drive` with the options that were given.
Drive changed_drive(const Values& values, Drive drive);

}  // namespace shaker::manual
