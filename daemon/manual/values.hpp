#pragma once
// The values of a command line, checked against the command's table; and the arguments that several commands
// have.
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/manual/command.hpp"
#include "drivers/point_fields.hpp"

namespace shaker::manual {

/// Names that are not in the table are an error of the program (std::logic_error).
class Values {
public:
    Values() = default;
    Values(const Program& program, const Command& command) : program_{&program}, command_{&command} {}

    /// Adds the texts given for an argument; none for a flag. InputError when a text is not allowed, naming
    /// the argument, the text and what is allowed.
    void add(const Argument& argument, std::vector<std::string> texts);

    /// True when the argument was given.
    [[nodiscard]] bool has(std::string_view name) const;
    /// The text that was given, else the standard value, else empty.
    [[nodiscard]] std::string text(std::string_view name) const;
    /// All texts that were given, else the standard value, else none.
    [[nodiscard]] std::vector<std::string> texts(std::string_view name) const;
    /// A quantity in SI units. The argument was given or has a standard value.
    [[nodiscard]] double number(std::string_view name) const;
    /// A whole number. The argument was given or has a standard value.
    [[nodiscard]] int whole(std::string_view name) const;

private:
    [[nodiscard]] const Argument& argument(std::string_view name) const;

    const Program* program_ = nullptr;
    const Command* command_ = nullptr;
    std::map<std::string, std::vector<std::string>, std::less<>> given_;
};

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
