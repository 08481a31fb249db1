#pragma once
// The laws of friction that are fitted to the points of campaigns, with their parameters.
// To add one: a row of `laws` here; where it needs another quantity, a member of LawSetting and its use in
// law_cycle.cpp.
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>

#include "drivers/walker/friction.hpp"
#include "drivers/walker/walker_setting.hpp"

namespace shaker::law {

/// Friction and bench at all points of a campaign.
struct LawSetting {
    walker::Friction friction{};  // mu_s: static_ratio times mu_k
    double static_ratio = 1;
    double tilt = 0;               // rad, positive: downhill towards +x
    double g = paper_g;            // m/s^2
    double push = 0;               // m/M_eff, see pushed_walker.hpp
    double excess = 0;             // mu is multiplied by 1 + excess e^{-t/excess_s},
    double excess_s = 60;          //   t: time since the first point, s
    double slope = 0, middle = 0;  // and by 1 + slope (x - middle), x: place on the base; 1/m, m
    double with = 0, quarter = 0;  // a_z over a_B, in phase and a quarter of a period later
};

/// A free parameter of a law beside mu.
struct LawParameter {
    std::string_view name, unit;   // unit: SI, "1" for a ratio
    double none;                   // value at which the law is Coulomb's
    double low, high;              // allowed
    std::array<double, 4> starts;  // values from which the fit begins; NaN: no more
    bool logarithmic;              // fitted as its logarithm
    double step;                   // of the derivative; relative where it is logarithmic
    void (*set)(LawSetting&, double);
};

struct Law {
    std::string_view name;   // in files and JSON
    std::string_view words;  // for people, with its assumption
    std::span<const LawParameter> parameters;
    walker::FrictionLaw friction = walker::FrictionLaw::coulomb;
    std::array<std::string_view, 3> contains{};  // laws that are a limit of this one
    enum class Needs { nothing, tilt, time, place } needs = Needs::nothing;
};

namespace parameters {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr LawParameter viscous{"c",   "1/s", 0,
                                      0,     200,   {1, nan, nan, nan},
                                      false, 0.02,  [](LawSetting& s, double x) { s.friction.viscous = x; }};
inline constexpr LawParameter presliding{
    "s_0", "m",  0,
    1e-8,  3e-4, {1e-6, 6e-6, 3e-5, 3e-8},
    true,  0.01, [](LawSetting& s, double x) { s.friction.presliding = x; }};
inline constexpr LawParameter static_share{
    "mu_s/mu_k", "1",  1,
    1,           4,    {1.1, nan, nan, nan},
    false,       2e-3, [](LawSetting& s, double x) { s.static_ratio = x; }};
inline constexpr LawParameter stribeck{
    "v_s", "m/s", 0,
    2e-4,  0.5,   {3e-3, 1.5e-2, 5e-2, 0.15},
    true,  0.01,  [](LawSetting& s, double x) { s.friction.stribeck = x; }};
inline constexpr LawParameter log_share{
    "B",   "1",  0,
    0,     1,    {0.02, nan, nan, nan},
    false, 1e-4, [](LawSetting& s, double x) { s.friction.log_share = x; }};
inline constexpr LawParameter backward{
    "mu backwards/forwards", "1", 1, 0.5, 2, {1, nan, nan, nan}, false, 1e-4, [](LawSetting& s, double x) {
        s.friction.backward = x;
    }};
inline constexpr LawParameter excess{"excess", "1",  0,
                                     -0.8,     4,    {0.01, nan, nan, nan},
                                     false,    1e-4, [](LawSetting& s, double x) { s.excess = x; }};
inline constexpr LawParameter excess_time{"its time", "s",  0,
                                          10,         1e5,  {30, 200, 1500, nan},
                                          true,       0.01, [](LawSetting& s, double x) { s.excess_s = x; }};
inline constexpr LawParameter slope{"slope", "1/m", 0,
                                    -50,     50,    {0, nan, nan, nan},
                                    false,   1e-3,  [](LawSetting& s, double x) { s.slope = x; }};
inline constexpr LawParameter with{
    "a_z/a_B in phase", "1", 0, -0.2, 0.2, {0, nan, nan, nan}, false, 1e-5, [](LawSetting& s, double x) {
        s.with = x;
    }};
inline constexpr LawParameter quarter{"a_z/a_B a quarter late",
                                      "1",
                                      0,
                                      -0.2,
                                      0.2,
                                      {0, nan, nan, nan},
                                      false,
                                      1e-5,
                                      [](LawSetting& s, double x) { s.quarter = x; }};

inline constexpr std::array of_viscous{viscous};
inline constexpr std::array of_static{static_share};
inline constexpr std::array of_logarithmic{log_share};
inline constexpr std::array of_dahl{presliding};
inline constexpr std::array of_dahl_viscous{presliding, viscous};
inline constexpr std::array of_stribeck{static_share, stribeck};
inline constexpr std::array of_unequal{backward};
inline constexpr std::array of_time{excess, excess_time};
inline constexpr std::array of_place{slope};
inline constexpr std::array of_vertical{with, quarter};

}  // namespace parameters

/// Simplest first. Friction has the equations.
inline constexpr std::array laws{
    Law{"coulomb", "Coulomb", {}},
    Law{"static",
        "Coulomb with mu_s above mu_k",
        parameters::of_static,
        walker::FrictionLaw::coulomb,
        {"coulomb"}},
    Law{"viscous", "Coulomb and viscous", parameters::of_viscous, walker::FrictionLaw::coulomb, {"coulomb"}},
    Law{"logarithmic",
        "logarithmic above 1 mm/s",
        parameters::of_logarithmic,
        walker::FrictionLaw::logarithmic,
        {"coulomb"}},
    Law{"dahl", "elastic contact (Dahl)", parameters::of_dahl, walker::FrictionLaw::dahl, {"coulomb"}},
    Law{"unequal",
        "Coulomb with unequal directions",
        parameters::of_unequal,
        walker::FrictionLaw::coulomb,
        {"coulomb"},
        Law::Needs::tilt},
    Law{"place",
        "Coulomb with mu that changes along x",
        parameters::of_place,
        walker::FrictionLaw::coulomb,
        {"coulomb"},
        Law::Needs::place},
    Law{"dahl_viscous",
        "elastic contact (Dahl) and viscous",
        parameters::of_dahl_viscous,
        walker::FrictionLaw::dahl,
        {"coulomb", "dahl", "viscous"}},
    Law{"stribeck",
        "Stribeck",
        parameters::of_stribeck,
        walker::FrictionLaw::stribeck,
        {"coulomb", "static"}},
    Law{"time",
        "Coulomb with mu that relaxes with time",
        parameters::of_time,
        walker::FrictionLaw::coulomb,
        {"coulomb"},
        Law::Needs::time},
    // No friction, but it can look like it.
    Law{.name = "vertical",
        .words = "Coulomb on a base that also shakes vertically",
        .parameters = parameters::of_vertical,
        .contains = {"coulomb"}}};

}  // namespace shaker::law
