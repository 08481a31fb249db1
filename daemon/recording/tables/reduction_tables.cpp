#include "daemon/recording/tables/reduction_tables.hpp"

#include <span>

namespace shaker::recording {

namespace {

using calibration::Estimate;
using calibration::Transverse;
using reduction::Corner;
using reduction::Cycle;
using reduction::GainRatio;
using reduction::MeasuredHarmonic;
using reduction::PeriodResult;
using reduction::RatioAt;
using reduction::Reduction;
using reduction::StickInterval;
using reduction::Systematic;
using reduction::Tilt;

using columns::error;
using columns::errors;
using columns::value;

template <std::size_t Axis>
double shaker_axis(const Reduction& r) {
    return r.shaker_axis[Axis];
}

template <std::size_t Axis>
double direction(const AcrossAt& a) {
    return a.across.direction[Axis];
}

constexpr std::array result_numbers{
    value<&Reduction::v_D>("v_D", "m/s", "drift velocity of the walker"),
    errors<&Reduction::v_D>("v_D_errors", "m/s",
                            "standard error, enlarged for few periods: twice this value covers 95 %"),
    value<&Reduction::D>("D", "m", "drift in one period"),
    errors<&Reduction::D>("D_errors", "m"),
    value<&Reduction::frequency>("frequency", "Hz", "drive frequency on master time"),
    errors<&Reduction::frequency>("frequency_errors", "Hz"),
    value<&Reduction::gamma>("gamma", "m/s^2", "A1 + A2: amplitudes of harmonics 1 and 2 of the base"),
    errors<&Reduction::gamma>("gamma_errors", "m/s^2"),
    value<&Reduction::rho>("rho", "1", "A1 / (A1 + A2)"),
    errors<&Reduction::rho>("rho_errors", "1"),
    value<&Reduction::phi>("phi", "rad", "phase of harmonic 2 minus twice that of harmonic 1"),
    errors<&Reduction::phi>("phi_errors", "rad"),
    value<&Reduction::v_rms>("v_rms", "m/s", "rms velocity of the base"),
    errors<&Reduction::v_rms>("v_rms_errors", "m/s"),
    value<&Reduction::efficiency>("efficiency", "1", "|v_D| / v_rms"),
    errors<&Reduction::efficiency>("efficiency_errors", "1"),
    value<&Reduction::accelerometer_late_s>("accelerometer_late", "s",
                                            "delay of the accelerometer relative to the pictures"),
    errors<&Reduction::accelerometer_late_s>("accelerometer_late_errors", "s"),
    value<&Reduction::accelerometer_ppm>(
        "accelerometer_ppm", "1e-6",
        "rate of the accelerometer's clock relative to that of the pictures, minus 1"),
    errors<&Reduction::accelerometer_ppm>("accelerometer_ppm_errors", "1e-6"),
    value<&Reduction::fit_residual_x_m>("fit_residual", "m", "rms of the walker's positions about the fit"),
    number<&Reduction::t0_s>("t0", "s", "master time of the first start of a period"),
    NumberColumn<Reduction>{"shaker_axis_x", "1",
                            "unit vector of the shaker's axis in sensor axes: x component", shaker_axis<0>},
    NumberColumn<Reduction>{"shaker_axis_y", "1",
                            "unit vector of the shaker's axis in sensor axes: y component", shaker_axis<1>},
    NumberColumn<Reduction>{"shaker_axis_z", "1",
                            "unit vector of the shaker's axis in sensor axes: z component", shaker_axis<2>},
    number<&Reduction::frames>("frames", "1", "used positions of the walker, all cameras"),
    number<&Reduction::frames_lost>("frames_lost", "1", "frames in which the walker was lost")};
constexpr Table<Reduction> result_columns{
    "results", "results of the newest finished measurement, or of the periods measured before a trip",
    result_numbers};

constexpr std::array systematic_numbers{
    number<&Reduction::systematic, &Systematic::v_D>("v_D", "m/s", "by the scales of the cameras"),
    number<&Reduction::systematic, &Systematic::D>("D", "m", "by the scales of the cameras"),
    number<&Reduction::systematic, &Systematic::gamma>("gamma", "m/s^2", "by the accelerometer's gain"),
    number<&Reduction::systematic, &Systematic::v_rms>("v_rms", "m/s", "by the accelerometer's gain"),
    number<&Reduction::systematic, &Systematic::efficiency>("efficiency", "1", "by both")};
constexpr Table<Reduction> systematic_columns{
    "systematic", "systematic standard errors of results by the calibrations; NaN: no calibration",
    systematic_numbers};

constexpr std::array check_numbers{
    value<&Reduction::gain_ratio, &GainRatio::ratio>(
        "ratio", "1", "acceleration of the base by the cameras over that by the accelerometer"),
    errors<&Reduction::gain_ratio, &GainRatio::ratio>("ratio_errors", "1", "statistical standard error"),
    number<&Reduction::gain_ratio, &GainRatio::systematic>(
        "ratio_systematic", "1",
        "relative systematic standard error by scales and gain; NaN: no calibration"),
    value<&Reduction::gain_ratio, &GainRatio::second_over_first>(
        "second_over_first", "1", "ratio at twice the drive frequency over that at the drive frequency"),
    errors<&Reduction::gain_ratio, &GainRatio::second_over_first>("second_over_first_errors", "1"),
    value<&Reduction::delay_s>("delay", "s", "accelerometer's clock minus master time, middle of the part"),
    errors<&Reduction::delay_s>("delay_errors", "s"),
    value<&Reduction::tilt, &Tilt::angle>("tilt", "rad",
                                          "slope of the shaker's axis by gravity; positive: +x downhill"),
    errors<&Reduction::tilt, &Tilt::angle>("tilt_errors", "rad",
                                           "standard error; NaN: the sensor's offset is not calibrated"),
    number<&Reduction::tilt, &Tilt::noise>("tilt_noise", "rad", "part of it by noise"),
    value<&Reduction::tilt, &Tilt::v_D>("tilt_v_D", "m/s", "part of v_D that the tilt causes, estimate"),
    errors<&Reduction::tilt, &Tilt::v_D>("tilt_v_D_errors", "m/s"),
    number<&Reduction::tilt, &Tilt::mu>("tilt_mu", "1", "friction coefficient used for this estimate")};
constexpr Table<Reduction> check_columns{
    "bench_check", "accelerometer and cameras compared by the base's motion; tilt by gravity", check_numbers};

constexpr std::array ratio_numbers{
    number<&RatioAt::view>("view", "1", "index of the camera among those that see the base, from 0"),
    number<&RatioAt::q>("q", "1", "harmonic of the drive frequency"),
    value<&RatioAt::ratio>("ratio", "1", "acceleration by this camera over that by the accelerometer"),
    errors<&RatioAt::ratio>("ratio_errors", "1"),
    value<&RatioAt::delay_s>("delay", "s", "of the camera behind the accelerometer on master time"),
    errors<&RatioAt::delay_s>("delay_errors", "s")};
constexpr Table<RatioAt> ratio_columns{"bench_check/views", "the comparison for each camera and harmonic",
                                       ratio_numbers};

constexpr std::array corner_numbers{
    value<&Reduction::corner, &Corner::phi_off>(
        "phi_off", "rad",
        "phi by the cameras minus phi by the accelerometer, corrected for its response; NaN: no "
        "comparison is possible"),
    errors<&Reduction::corner, &Corner::phi_off>("phi_off_errors", "rad"),
    value<&Reduction::corner, &Corner::hz>(
        "corner", "Hz",
        "lower corner of the accelerometer that the results are corrected for; NaN: none, or not known"),
    errors<&Reduction::corner, &Corner::hz>("corner_errors", "Hz"),
    number<&Reduction::systematic, &Systematic::phi>(
        "phi_systematic", "rad",
        "standard error of phi by the errors of high_pass_hz and low_pass_hz; NaN: neither is set")};
constexpr Table<Reduction> corner_columns{"bench_check/phases",
                                          "phases of the base by accelerometer and cameras", corner_numbers};

constexpr std::array harmonic_numbers{
    number<&MeasuredHarmonic::q>("q", "1", "harmonic of the drive frequency"),
    value<&MeasuredHarmonic::amplitude>("amplitude", "m/s^2", "acceleration of the base along the axis"),
    errors<&MeasuredHarmonic::amplitude>("amplitude_errors", "m/s^2"),
    value<&MeasuredHarmonic::phase>("phase", "rad", "relative to sin(q w t), with t = 0 at t0"),
    errors<&MeasuredHarmonic::phase>("phase_errors", "rad")};
constexpr Table<MeasuredHarmonic> harmonic_columns{"harmonics", "motion of the base along the shaker's axis",
                                                   harmonic_numbers};

constexpr std::array transverse_numbers{
    number<&AcrossAt::frequency_hz>("frequency", "Hz", "frequency of the harmonic"),
    value<&AcrossAt::across, &Transverse::amplitude>("amplitude", "m/s^2",
                                                     "acceleration of the base across the shaker's axis"),
    errors<&AcrossAt::across, &Transverse::amplitude>("amplitude_errors", "m/s^2"),
    value<&AcrossAt::across, &Transverse::share>("share", "1", "amplitude across / amplitude along"),
    errors<&AcrossAt::across, &Transverse::share>("share_errors", "1"),
    number<&AcrossAt::across, &Transverse::in_phase>("in_phase", "1",
                                                     "part of the share in phase with the motion along"),
    number<&AcrossAt::across, &Transverse::quadrature>("quadrature", "1", "part of the share in quadrature"),
    NumberColumn<AcrossAt>{"direction_x", "1",
                           "direction of the strongest motion in sensor axes: x component", direction<0>},
    NumberColumn<AcrossAt>{"direction_y", "1",
                           "direction of the strongest motion in sensor axes: y component", direction<1>},
    NumberColumn<AcrossAt>{"direction_z", "1",
                           "direction of the strongest motion in sensor axes: z component", direction<2>}};

constexpr std::array period_numbers{
    number<&PeriodResult::k>("k", "1", "number of the period, counted from the first whole one"),
    number<&PeriodResult::t_s>("t", "s", "start of the period, master time"),
    number<&PeriodResult::frames>("frames", "1", "positions of the walker in this period"),
    value<&PeriodResult::drift>("D", "m",
                                "mean position minus that of the previous period; NaN in the first period"),
    errors<&PeriodResult::drift>("D_errors", "m"),
    value<&PeriodResult::gamma>("gamma", "m/s^2", "as in results, but from this period alone"),
    errors<&PeriodResult::gamma>("gamma_errors", "m/s^2"),
    value<&PeriodResult::phi>("phi", "rad", "as in results, but from this period alone"),
    errors<&PeriodResult::phi>("phi_errors", "rad")};
constexpr Table<PeriodResult> period_columns{
    "periods", "results of each period", period_numbers, {}, {.signal = "D", .axes = "t"}};

struct CyclePoint {
    double phase = 0, x_m = 0, x_sd_m = 0, v_mps = 0, v_sd_mps = 0, v_base_mps = 0;
};
constexpr std::array cycle_numbers{
    number<&CyclePoint::phase>("phase", "1",
                               "time since the start of the period / length of the period, 0..1"),
    number<&CyclePoint::x_m>("x", "m", "position of the walker minus its position at phase 0"),
    number<&CyclePoint::x_sd_m>("x_errors", "m", error),
    number<&CyclePoint::v_mps>("v", "m/s", "velocity of the walker"),
    number<&CyclePoint::v_sd_mps>("v_errors", "m/s", error),
    number<&CyclePoint::v_base_mps>("v_base", "m/s", "velocity of the base")};
constexpr Table<CyclePoint> cycle_columns{
    "cycle",
    "motion over one period, averaged over all periods; the default plot",
    cycle_numbers,
    {},
    {.signal = "v", .axes = "phase", .title = "walker velocity over one period"}};

constexpr std::array stick_numbers{
    number<&StickInterval::from>("from", "1", "start of an interval of rest on the base, in periods"),
    number<&StickInterval::to>("to", "1",
                               "end of the interval; above 1 when it continues in the next period"),
    number<&StickInterval::sd>("errors", "1", "standard error of start and end")};
constexpr Table<StickInterval> stick_columns{"stick", "intervals in which the walker rests on the base",
                                             stick_numbers};

constexpr std::array note_texts{
    text<&Note::text>("text", sentence_bytes, "one sentence on the results or on the data")};

std::vector<CyclePoint> points_of(const reduction::Cycle& c) {
    std::vector<CyclePoint> points(c.phase.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = {c.phase[i],    c.x_m.at(i),      c.x_sd_m.at(i),
                     c.v_mps.at(i), c.v_sd_mps.at(i), c.v_base_mps.at(i)};
    return points;
}

}  // namespace

constexpr Table<AcrossAt> transverse_columns{
    "transverse",
    "motion of the base across the shaker's axis",
    transverse_numbers,
    {},
    {.signal = "share", .axes = "frequency", .title = "motion across the shaker's axis over that along it"}};

constexpr Table<Note> note_columns{"results/notes", "remarks on the results", {}, note_texts};

std::vector<RecordedNumber> numbers_of(const Reduction& reduction) {
    return numbers_of(result_columns, reduction);
}

std::vector<RecordedTable> tables_of(const Reduction& r) {
    std::vector<AcrossAt> across;
    for (const MeasuredHarmonic& h : r.harmonics) across.push_back({h.q * r.frequency.value, h.across});
    return {table_of(harmonic_columns, r.harmonics),   table_of(transverse_columns, across),
            table_of(period_columns, r.periods),       table_of(cycle_columns, points_of(r.cycle)),
            table_of(stick_columns, r.stick),          table_of(systematic_columns, std::span{&r, 1}),
            table_of(check_columns, std::span{&r, 1}), table_of(ratio_columns, r.gain_ratio.at),
            table_of(corner_columns, std::span{&r, 1})};
}

bool is_later(const RecordedTable& table) {
    return table.path.ends_with(systematic_columns.path) || table.path.ends_with(check_columns.path) ||
           table.path.ends_with(ratio_columns.path) || table.path.ends_with(corner_columns.path);
}

std::map<int, Reduction> read_reductions(const recorded::RecordingReader& file, const std::string& below,
                                         const char* number) {
    std::map<int, Reduction> out;
    const auto read = [&]<class Row>(const Table<Row>& table, const auto& take) {
        const std::string path = below + "/" + table.path;
        const std::vector<Row> rows = read_rows(file, table, path);
        const std::vector<double> numbers = file.numbers(path + "/" + number);
        if (numbers.size() != rows.size())
            refuse_length(path, number, numbers.size(), table.numbers.front().name, rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            int of = 0;
            if (!columns::take(of, numbers[i])) refuse_value(path, number, i, std::to_string(numbers[i]));
            take(of, rows[i]);
        }
    };
    read(result_columns, [&](int of, const Reduction& r) { out[of] = r; });
    read(harmonic_columns, [&](int of, const MeasuredHarmonic& h) { out[of].harmonics.push_back(h); });
    read(period_columns, [&](int of, const PeriodResult& p) { out[of].periods.push_back(p); });
    read(cycle_columns, [&](int of, const CyclePoint& p) {
        Cycle& c = out[of].cycle;
        c.phase.push_back(p.phase);
        c.x_m.push_back(p.x_m);
        c.x_sd_m.push_back(p.x_sd_m);
        c.v_mps.push_back(p.v_mps);
        c.v_sd_mps.push_back(p.v_sd_mps);
        c.v_base_mps.push_back(p.v_base_mps);
    });
    read(stick_columns, [&](int of, const StickInterval& s) { out[of].stick.push_back(s); });
    if (!file.has(below + "/" + check_columns.path)) return out;  // versions up to 5
    read(systematic_columns, [&](int of, const Reduction& r) { out[of].systematic = r.systematic; });
    read(check_columns, [&](int of, const Reduction& r) {
        Reduction& to = out[of];
        to.gain_ratio = r.gain_ratio;
        to.delay_s = r.delay_s;
        to.tilt = r.tilt;
    });
    read(ratio_columns, [&](int of, const RatioAt& r) { out[of].gain_ratio.at.push_back(r); });
    if (file.has(below + "/" + corner_columns.path))  // not in versions up to 6 and the first files of 7
        read(corner_columns, [&](int of, const Reduction& r) {
            out[of].corner = r.corner;
            out[of].systematic.phi = r.systematic.phi;
        });
    return out;
}

std::vector<recorded::GroupLayout> reduction_places() {
    return {places_of(result_columns),     layout_of(harmonic_columns), layout_of(transverse_columns),
            layout_of(period_columns),     layout_of(cycle_columns),    layout_of(stick_columns),
            layout_of(systematic_columns), layout_of(check_columns),    layout_of(ratio_columns),
            layout_of(corner_columns)};
}

void write(recorded::RecordingWriter& file, const Reduction& reduction, const MeasuredPart& part) {
    write_reduced_part(file, part);
    std::vector<RecordedTable> tables = tables_of(reduction);
    keep_known(tables, file);
    write(file, tables);
    write(file, numbers_of(reduction));
    std::vector<Note> notes;
    for (const std::string& text : reduction.notes) notes.push_back({text});
    write_rows(file, note_columns, notes);
}

}  // namespace shaker::recording
