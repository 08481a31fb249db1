#include "daemon/commands/predict.hpp"

#include <algorithm>
#include <charconv>
#include <complex>
#include <cstdio>

#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"
#include "drivers/walker/friction.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;
using manual::quantity_option;

constexpr Range allowed_mu{0, 100};

constexpr Argument a_number(std::string_view name, std::string_view help, Range allowed,
                            std::string_view standard, Dimension dimension = Dimension::ratio) {
    const std::string_view value = dimension == Dimension::time       ? "TIME"
                                   : dimension == Dimension::velocity ? "VELOCITY"
                                                                      : "X";
    return quantity_option(name, value, dimension, allowed, help, standard);
}

constexpr std::array friction_law_arguments{
    Argument{.name = "--law",
             .help = "Law of friction",
             .kind = Kind::word,
             .words = walker::friction_laws,
             .standard = "coulomb"},
    quantity_option("--mu-backward", "MU", Dimension::ratio, allowed_mu,
                    "Kinetic friction coefficient of backward slip; static friction has the same ratio", {},
                    "--mu"),
    a_number("--log-share", "Law logarithmic: growth of mu per factor e of the slip velocity", {0, 10},
             "0.1"),
    a_number("--log-velocity", "Law logarithmic: velocity at which the growth begins", {1e-6, 10}, "1mm/s",
             Dimension::velocity),
    a_number("--presliding", "Laws dahl and lugre: elastic length of the contact, m", {1e-8, 1e-3}, "7.2e-6"),
    a_number("--stribeck", "Laws stribeck and lugre: velocity over which mu falls from --mu-s to --mu",
             {1e-5, 10}, "5mm/s", Dimension::velocity),
    a_number("--bristle-time", "Law lugre: damping over stiffness of the contact", {0, 1}, "0.1ms",
             Dimension::time),
    a_number("--ageing", "Growth of the static friction per factor e of the time at rest", {0, 1}, "0"),
    a_number("--ageing-time", "Time at rest at which the growth begins", {1e-6, 1e3}, "1ms", Dimension::time),
    a_number("--roughness", "Scatter of mu along the base, rms", {0, 0.2}, "0"),
    a_number("--roughness-length", "Wavelength of that scatter, m", {1e-5, 10}, "0.005"),
    a_number("--jitter", "Scatter of mu from period to period, rms", {0, 0.3}, "0"),
    a_number("--memory", "Correlation of mu between successive periods", {0, 0.9999}, "0"),
    a_number("--relaxation", "Excess of mu at the start", {-0.9, 10}, "0"),
    a_number("--relaxation-time", "Time constant of that excess", {1e-3, 1e6}, "10s", Dimension::time),
    manual::whole_option("--seed", "N", {0, 2147483647}, "Seed of --jitter and --roughness", "1"),
    manual::whole_option("--periods", "N", {16, 1000000}, "Periods to average where mu changes", "1000")};

constexpr auto predict_arguments = manual::joined(
    manual::drive_arguments(true),
    std::array{
        Argument{.name = "--harmonics",
                 .value = "LIST",
                 .help = "Harmonics of the base's acceleration in place of --gamma, --rho and --phi, e.g. "
                         "1:0.5g@0,2:0.5g@35deg,3:0.1m/s^2@90deg",
                 .kind = Kind::text},
        Argument{.name = "--vertical",
                 .value = "LIST",
                 .help = "Harmonics of the base's vertical acceleration",
                 .kind = Kind::text},
        quantity_option("--mu", "MU", Dimension::ratio, allowed_mu, "Kinetic friction coefficient", "0.113"),
        quantity_option("--mu-s", "MU", Dimension::ratio, allowed_mu,
                        "Static friction coefficient, at least --mu", {}, "--mu"),
        quantity_option("--viscous", "C", Dimension::ratio, {0, 1e4},
                        "Velocity strengthening of the friction, 1/s", "0"),
        quantity_option("--tilt", "ANGLE", Dimension::angle, {-1.5, 1.5},
                        "Tilt of the base, downhill towards +x, e.g. 0.1deg", "0deg"),
        quantity_option("--start", "VELOCITY", Dimension::velocity, {-100, 100},
                        "Velocity of the walker at phase 0, e.g. 20mm/s; with --mu-s above --mu the settled "
                        "motion may depend on it",
                        "0mm/s"),
        Argument{.name = "--json",
                 .value = "CASES",
                 .help = "Print JSON. With a file: for each case in the file (format: "
                         "tests/golden/physics_reference.json)",
                 .kind = Kind::file,
                 .bare = true}},
    friction_law_arguments);

constexpr Range allowed_amplitudes{0, 1e6}, allowed_phases{-100, 100};

int order_of(std::string_view option, std::string_view item, std::string_view text) {
    int q = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), q);
    if (error == std::errc{} && end == text.data() + text.size() && q >= 1 && q <= max_harmonics) return q;
    throw InputError{std::string{option} + " \"" + std::string{item} +
                     "\": the order of a harmonic is 1 to " + std::to_string(max_harmonics) +
                     "; expected ORDER:AMPLITUDE@PHASE, e.g. 2:4.9m/s^2@35deg"};
}

}  // namespace

Harmonics<Acceleration> parse_harmonics(std::string_view option, std::string_view text) {
    Harmonics<Acceleration> h;
    while (!text.empty()) {
        const std::string_view item = text.substr(0, text.find(','));
        text.remove_prefix(std::min(text.size(), item.size() + 1));
        const std::size_t colon = std::min(item.find(':'), item.size());
        const int q = order_of(option, item, item.substr(0, colon));
        const std::string_view value = item.substr(std::min(colon + 1, item.size()));
        const std::size_t at = std::min(value.find('@'), value.size());
        const double amplitude =
            parse_quantity(option, value.substr(0, at), Dimension::acceleration, allowed_amplitudes);
        const double phase = at == value.size() ? 0
                                                : parse_quantity(option, value.substr(at + 1),
                                                                 Dimension::angle, allowed_phases);
        if (h.at(q) != 0.0)
            throw InputError{std::string{option} + ": harmonic " + std::to_string(q) + " is given twice"};
        h.at(q) = std::polar(amplitude, phase);
    }
    return h;
}

namespace {

walker::Friction friction_of(const manual::Values& values) {
    walker::Friction f;
    f.mu_k = values.number("--mu");
    f.mu_s = values.has("--mu-s")
                 ? parse_quantity("--mu-s", values.text("--mu-s"), Dimension::ratio, {f.mu_k, allowed_mu.max})
                 : f.mu_k;
    f.viscous = values.number("--viscous");
    if (values.has("--mu-backward")) {
        if (f.mu_k == 0) throw InputError{"--mu-backward needs a --mu above 0"};
        f.backward = parse_quantity("--mu-backward", values.text("--mu-backward"), Dimension::ratio,
                                    {0.1 * f.mu_k, 10 * f.mu_k}) /
                     f.mu_k;
    }
    const std::string law = values.text("--law");
    f.law = static_cast<walker::FrictionLaw>(std::ranges::find(walker::friction_laws, law) -
                                             walker::friction_laws.begin());
    f.log_share = values.number("--log-share");
    f.log_velocity = values.number("--log-velocity");
    f.presliding = values.number("--presliding");
    f.stribeck = values.number("--stribeck");
    f.bristle_time = values.number("--bristle-time");
    f.ageing = values.number("--ageing");
    f.ageing_s = values.number("--ageing-time");
    const auto seed = static_cast<std::uint64_t>(values.whole("--seed"));
    f.roughness = {values.number("--roughness"), values.number("--roughness-length"), seed};
    f.change = {values.number("--jitter"), values.number("--memory"), values.number("--relaxation"),
                values.number("--relaxation-time"), seed};
    return f;
}

/// Harmonics in place of the drive's, which must not be given beside them.
std::optional<Harmonics<Acceleration>> given_base(const manual::Values& values) {
    if (!values.has("--harmonics")) return std::nullopt;
    for (const char* option : {"--gamma", "--rho", "--phi"})
        if (values.has(option))
            throw InputError{std::string{option} +
                             " and --harmonics both describe the drive; use one of them"};
    return parse_harmonics("--harmonics", values.text("--harmonics"));
}

int act_on_predict(const manual::Values& values) {
    if (const std::string cases = values.text("--json"); !cases.empty()) {
        std::fputs(predict_cases(cases).c_str(), stdout);
        return manual::exit_ok;
    }
    PredictOptions o{.drive = changed_drive(values, {})};
    o.base = given_base(values);
    o.vertical = parse_harmonics("--vertical", values.text("--vertical"));
    o.friction = friction_of(values);
    o.periods = values.whole("--periods");
    o.tilt = values.number("--tilt");
    o.v_start = values.number("--start");
    o.json = values.has("--json");
    std::fputs(predict(o).c_str(), stdout);
    return manual::exit_ok;
}

}  // namespace

manual::Command predict_row() {
    return {.name = "predict",
            .summary = "Predict the walker's motion: any law of friction, and closed form",
            .arguments = predict_arguments,
            .example = "shakerd predict --gamma 1.5g --phi 35deg --mu 0.113",
            .act = act_on_predict};
}

}  // namespace shaker::commands
