#pragma once
// The rows of the table of orders, for tables that are made from them when the program is compiled.
#include <algorithm>
#include <array>
#include <utility>

#include "daemon/orders/row.hpp"
#include "drivers/point_fields.hpp"

namespace shaker::orders {

namespace of {

/// When an order that begins a drive is allowed: at rest only. refused_in_campaign: as When::not_in_campaign.
constexpr When begins(std::string_view refused_in_campaign) {
    return {.driven = false,
            .tripped = false,
            .not_in_campaign = refused_in_campaign,
            .starts = true,
            .may_drive = true};
}

/// An order to a campaign under way, refused without one.
constexpr Row to_campaign(std::string_view name, std::string_view summary, std::string_view scpi,
                          std::string_view log) {
    const When in_campaign{.at_rest = false, .driven = false, .tripped = false};
    return {.name = name, .summary = summary, .scpi = scpi, .when = in_campaign, .log = log};
}

constexpr Field from(const PointField& p) {
    return {.key = p.key,
            .option = p.option,
            .value = p.placeholder,
            .help = p.help,
            .kind = Kind::quantity,
            .dimension = p.dimension,
            .allowed = p.allowed};
}

constexpr Field from(const MeasurementField& m) {
    return {.key = m.key,
            .option = m.option,
            .value = "N",
            .help = m.help,
            .kind = Kind::whole,
            .allowed = m.allowed,
            .otherwise = m.otherwise};
}

inline constexpr std::array drive{from(point_fields[0]), from(point_fields[1]), from(point_fields[2]),
                                  from(point_fields[3])};

inline constexpr std::array start{from(measurement_fields[0]),
                                  from(measurement_fields[1]),
                                  from(measurement_fields[2]),
                                  drive[0],
                                  drive[1],
                                  drive[2],
                                  drive[3]};

inline constexpr std::array mu{Field{.key = "mu",
                                     .option = "MU",
                                     .help = "Coefficient of Coulomb friction",
                                     .kind = Kind::quantity,
                                     .allowed = allowed_friction,
                                     .needed = true},
                               Field{.key = "sigma",
                                     .option = "--error",
                                     .value = "ERROR",
                                     .help = "Standard error of MU",
                                     .kind = Kind::quantity,
                                     .allowed = {0, allowed_friction.max},
                                     .otherwise = "0"}};

inline constexpr std::array targets{Field{.key = "targets",
                                          .help = "Targets to move: camera, target and region_px (x, y, "
                                                  "width, height) of each",
                                          .kind = Kind::regions,
                                          .needed = true,
                                          .scpi = false}};

inline constexpr std::array<std::string_view, 2> scanned{"phi", "gamma"};
inline constexpr std::array campaign{
    Field{.key = "plan", .help = "Plan to measure, without folder or ending"},
    Field{.key = "scan",
          .option = "WHAT",
          .help = "phi or gamma: the parameter that changes; the set-point gives the others",
          .kind = Kind::word,
          .words = scanned,
          .scpi = false},
    Field{.key = "from",
          .option = "--from",
          .value = "VALUE",
          .help = "First value, e.g. 0deg or 0.5g",
          .kind = Kind::free,
          .otherwise = "needed",
          .scpi = false},
    Field{.key = "to",
          .option = "--to",
          .value = "VALUE",
          .help = "Last value",
          .kind = Kind::free,
          .otherwise = "needed",
          .scpi = false},
    Field{.key = "steps",
          .option = "--steps",
          .value = "N",
          .help = "Number of values, evenly spaced",
          .kind = Kind::whole,
          .allowed = {1, 1000},
          .otherwise = "needed",
          .scpi = false},
    Field{.key = "periods",
          .option = "--periods",
          .value = "N",
          .help = measurement_fields[0].help,
          .kind = Kind::whole,
          .allowed = measurement_fields[0].allowed,
          .otherwise = "as last",
          .scpi = false},
    Field{.key = "repeats",
          .option = "--repeats",
          .value = "N",
          .help = "Passes of the whole scan",
          .kind = Kind::whole,
          .allowed = {1, 1000},
          .otherwise = "1",
          .scpi = false}};

inline constexpr std::array remark{Field{.key = "text",
                                         .option = "TEXT",
                                         .help = "1 to 400 bytes in quotes: \"new paper under the walker\"",
                                         .needed = true}};

inline constexpr std::array loop{
    Field{.key = "closed", .option = "SWITCH", .help = "on or off", .kind = Kind::flag, .needed = true}};

inline constexpr std::array<std::string_view, 8> limits{
    "acceleration", "acceleration_rms", "coil", "velocity", "displacement", "drive", "transverse", "edge"};
inline constexpr std::array<std::string_view, 2> levels{"abort", "warn"};
inline constexpr std::array limit{
    Field{.key = "limit",
          .option = "LIMIT",
          .help = "Limit to tighten; edge: least distance of the walker from the edge of the picture",
          .kind = Kind::word,
          .words = limits,
          .needed = true},
    Field{.key = "value",
          .option = "VALUE",
          .help = "Its new value, e.g. 12m/s^2, 5mm or 0.4; V and A without a unit",
          .kind = Kind::free,
          .needed = true},
    Field{.key = "level",
          .option = "--level",
          .value = "LEVEL",
          .help = "Level of the limit; edge has one only",
          .kind = Kind::word,
          .words = levels,
          .otherwise = "abort"}};

inline constexpr std::array<std::string_view, 4> pictures{"off", "first-second", "region", "full"};
inline constexpr std::array record{
    Field{.key = "on", .option = "SWITCH", .help = "on or off", .kind = Kind::flag},
    Field{.key = "name",
          .option = "--name",
          .value = "NAME",
          .help = "Name of the next recording, without folder or ending",
          .otherwise = "the time"},
    Field{.key = "frames",
          .option = "--frames",
          .value = "WHICH",
          .help = "Pictures to record: off, first-second (those of the first second; then positions "
                  "only), region (all, "
                  "of the part that can contain targets) or full",
          .kind = Kind::word,
          .words = pictures,
          .otherwise = "as last",
          .scpi = false}};

}  // namespace of

inline constexpr std::array<Row, 20> table{{
    {.name = "drive",
     .summary = "Change the drive",
     .details = "Settings that are not given keep their values.",
     .example = "shakerctl set --gamma 1.5g --phi 35deg",
     .fields = of::drive,
     .when = {.not_in_campaign = "the set-point cannot be changed", .may_drive = true}},
    {.name = "start",
     .summary = "Start the drive and measure",
     .details =
         "The bench repeats the measurement until it is stopped, or N times with --measurements N. A drive "
         "that is given is set with the start, or not at all.",
     .example = "shakerctl start --periods 40 --wait",
     .fields = of::start,
     .when = of::begins("the bench cannot be started")},
    {.name = "stop",
     .summary = "Ramp the drive down softly",
     .when = {.at_rest = false, .tripped = false, .outlasts_abort = true, .overtakes = true},
     .log = "stop"},
    {.name = "identify",
     .summary = "Measure the response of the base to the drive at a low level",
     .scpi = "CONTrol:IDENtify[:STARt]",
     .when = of::begins("the response cannot be identified"),
     .log = "identification"},
    {.name = "middle",
     .summary = "Bring the walker to the middle of the picture",
     .details = "A drive of at least 1 g at phi 0 or 180 deg leads it there from rest, also from beyond "
                "the limit at the edge; then the bench is idle. The set-point stays. The order is refused "
                "while it is not certain that the walker goes inwards.",
     .example = "shakerctl clear && shakerctl middle --wait",
     .scpi = "OUTPut:MIDDle",
     .when = of::begins("the walker cannot be brought to the middle"),
     .log = "return to the middle"},
    {.name = "reset-walker",
     .summary = "Put the walker of a simulated bench back to the middle of its base",
     .details = "At rest only. The log has a note. A bench with real devices refuses the order.",
     .example = "shakerctl clear && shakerctl reset-walker",
     .scpi = "[SOURce:]WALKer:RESet",
     .when = {.driven = false, .tripped = false, .not_in_campaign = "the walker cannot be put back"},
     .log = "walker put back"},
    {.name = "clear",
     .summary = "Clear a trip or an abort, so that the drive can start again",
     .when = {.at_rest = false, .driven = false, .may_drive = true},
     .log = "clear"},
    {.name = "campaign",
     .summary = "Measure the points of a plan, or a scan of one parameter",
     .details =
         "The set-point and the last number of periods hold for what a scan does not give. The recordings "
         "and the table of points are in a folder of their own, as of a plan.",
     .example = "shakerctl scan phi --from 0deg --to 180deg --steps 13 --wait",
     .fields = of::campaign,
     .scpi = "CAMPaign:STARt",
     .when = of::begins("no other campaign can begin")},
    {.name = "campaign/check",
     .summary = "Check how long a plan or a scan takes, and which points do not fit",
     .fields = of::campaign,
     .scpi = "CAMPaign:CHECk"},
    of::to_campaign("campaign/pause", "Pause the campaign after the present measurement", "CAMPaign:PAUSe",
                    "campaign pause"),
    of::to_campaign("campaign/resume", "Go on with a campaign that is paused", "CAMPaign:RESume",
                    "campaign resume"),
    of::to_campaign("campaign/skip", "Leave the point in progress out", "CAMPaign:SKIP", "campaign skip"),
    of::to_campaign("campaign/repeat", "Measure the last point again", "CAMPaign:REPeat", "campaign repeat"),
    of::to_campaign("campaign/stop", "End the campaign after the point in progress", "CAMPaign:STOP",
                    "campaign stop"),
    {.name = "mu",
     .summary = "Give the friction coefficient of walker and base",
     .details = "Walks are predicted by it until the measurements give a coefficient.",
     .fields = of::mu,
     .scpi = "[SOURce:]WALKer:MU"},
    {.name = "targets",
     .summary = "Move the regions in which the cameras' targets are searched",
     .fields = of::targets,
     .when = {.driven = false, .not_in_campaign = "the targets cannot be moved"}},
    {.name = "remark",
     .summary = "Add a remark to the log and to the recording",
     .details = "Without a recording under way, the remark goes into the next one.",
     .example = "shakerctl remark \"new paper under the walker\"",
     .fields = of::remark,
     .scpi = "RECord:NOTE",
     .when = {.outlasts_abort = true}},
    {.name = "loop",
     .summary = "Correct the drive by the measured harmonics, or not, from the next start on",
     .details = "At rest only. With the loop closed the base's motion is kept at the set-point.",
     .example = "shakerctl loop on",
     .fields = of::loop,
     .scpi = "CONTrol:LOOP[:STATe]",
     .when = {.driven = false, .tripped = false, .not_in_campaign = "the loop cannot be switched"}},
    {.name = "record",
     .summary = "Switch recording on or off, of the run under way and of the following runs",
     .details = "In a run, on starts a file as soon as the drive has settled again, without pictures or with "
                "those of its first second; off completes the file, and the run goes on.",
     .example = "shakerctl record on --name series-1",
     .fields = of::record,
     .scpi = "RECord[:STATe]",
     .when = {.not_in_campaign = "recording cannot be switched"}},
    {.name = "limit",
     .summary = "Tighten a limit until the daemon ends",
     .details = "Only the settings file can loosen a limit.",
     .example = "shakerctl limit acceleration 12m/s^2",
     .fields = of::limit,
     .when = {.outlasts_abort = true, .overtakes = true}},
}};

/// Index of the row with this name; table.size() when no row has it.
constexpr std::size_t place_of(std::string_view name) {
    return static_cast<std::size_t>(std::ranges::find(table, name, &Row::name) - table.begin());
}

}  // namespace shaker::orders
