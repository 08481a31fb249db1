#include "daemon/commands/predict.hpp"

#include <cstdio>

#include "daemon/command_line/rows.hpp"
#include "daemon/manual/drive_arguments.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr Range frictions{0, 100};

constexpr auto arguments = manual::joined(
    manual::drive_arguments(true),
    std::array{
        Argument{.name = "--mu",
                 .value = "MU",
                 .help = "Kinetic friction coefficient",
                 .kind = Kind::quantity,
                 .dimension = Dimension::ratio,
                 .allowed = frictions,
                 .standard = "0.113"},
        Argument{.name = "--mu-s",
                 .value = "MU",
                 .help = "Static friction coefficient, at least --mu",
                 .kind = Kind::quantity,
                 .dimension = Dimension::ratio,
                 .allowed = frictions,
                 .otherwise = "--mu"},
        Argument{.name = "--viscous",
                 .value = "C",
                 .help = "Velocity strengthening of the friction, 1/s",
                 .kind = Kind::quantity,
                 .dimension = Dimension::ratio,
                 .allowed = {0, 1e4},
                 .standard = "0"},
        Argument{.name = "--tilt",
                 .value = "ANGLE",
                 .help = "Tilt of the base, downhill towards +x, e.g. 0.1deg",
                 .kind = Kind::quantity,
                 .dimension = Dimension::angle,
                 .allowed = {-1.5, 1.5},
                 .standard = "0deg"},
        Argument{.name = "--start",
                 .value = "VELOCITY",
                 .help = "Velocity of the walker at phase 0, e.g. 20mm/s; with --mu-s above --mu the settled "
                         "motion may "
                         "depend on it",
                 .kind = Kind::quantity,
                 .dimension = Dimension::velocity,
                 .allowed = {-100, 100},
                 .standard = "0mm/s"},
        Argument{.name = "--json",
                 .value = "CASES",
                 .help = "Print JSON. With a file: for each case in the file (format: "
                         "tests/golden/physics_reference.json)",
                 .kind = Kind::file,
                 .bare = true}});

int act(const manual::Values& values) {
    if (const std::string cases = values.text("--json"); !cases.empty()) {
        std::fputs(commands::predict_cases(cases).c_str(), stdout);
        return manual::exit_ok;
    }
    commands::PredictOptions o{.drive = changed_drive(values, {})};
    o.friction.mu_k = values.number("--mu");
    o.friction.mu_s = values.has("--mu-s") ? parse_quantity("--mu-s", values.text("--mu-s"), Dimension::ratio,
                                                            {o.friction.mu_k, frictions.max})
                                           : o.friction.mu_k;
    o.friction.viscous = values.number("--viscous");
    o.tilt = values.number("--tilt");
    o.v_start = values.number("--start");
    o.json = values.has("--json");
    std::fputs(predict(o).c_str(), stdout);
    return manual::exit_ok;
}

}  // namespace

manual::Command predict_row() {
    return {.name = "predict",
            .summary = "Predict the walker's motion: Coulomb friction and closed form",
            .arguments = arguments,
            .example = "shakerd predict --gamma 1.5g --phi 35deg --mu 0.113",
            .act = act};
}

}  // namespace shaker::command_line
