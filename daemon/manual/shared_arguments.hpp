#pragma once
// Arguments that several commands have.
#include <array>
#include <string>

#include "daemon/manual/values.hpp"
#include "drivers/point_fields.hpp"

namespace shaker::manual {

inline constexpr Argument json_argument{.name = "--json",
                                        .help = "Print one JSON object; key names carry the SI units"};
inline constexpr Argument scene_argument{.name = "--scene",
                                         .value = "FILE",
                                         .help = "TOML file that changes the simulated bench",
                                         .kind = Kind::file};
inline constexpr Argument rig_argument{
    .name = "--rig",
    .value = "RIG",
    .help = "Rig file (TOML) that names the devices, or sim: for the simulated bench",
    .kind = Kind::file,
    .standard = "sim:"};

/// The option of a parameter. defaults: help shows the value that is used when it is not given.
constexpr Argument argument_of(const PointField& field, bool defaults) {
    return {.name = field.option,
            .value = field.placeholder,
            .help = field.help,
            .kind = field.whole() ? Kind::whole : Kind::quantity,
            .dimension = field.dimension,
            .allowed = field.allowed,
            .standard = defaults ? field.standard : std::string_view{}};
}

/// --gamma, --phi, --rho and --frequency. defaults: help shows the values of Drive{}, which are used for
/// options that are not given.
constexpr std::array<Argument, drive_fields> drive_arguments(bool defaults) {
    return {argument_of(point_fields[0], defaults), argument_of(point_fields[1], defaults),
            argument_of(point_fields[2], defaults), argument_of(point_fields[3], defaults)};
}

/// A remark on a --gamma without a unit that is far below 1 g and was perhaps meant in g; empty without one.
std::string doubtful_gamma(const Values& values);
/// `drive` with the options that were given.
Drive changed_drive(const Values& values, Drive drive);

}  // namespace shaker::manual
