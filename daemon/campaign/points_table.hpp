#pragma once
// The points table of a campaign: one row for each point, and the rows of its harmonics, cycle, stick
// intervals and passes. POINTS.md lists the columns.
#include <string>
#include <vector>

#include "calibration/estimate.hpp"
#include "daemon/export/tables.hpp"
#include "daemon/recording/tables/columns.hpp"
#include "daemon/reduction/reduction.hpp"
#include "drivers/drive.hpp"

namespace shaker::campaign {

struct PointRow {
    int point = 0;  // 1, 2, ... in the order of the plan
    std::string series{};
    int repeat = 1;
    int partner = 0;  // number of the mirror partner; 0: none
    Drive asked{};
    std::string outcome = "not begun", reason{};
    // Results; NaN unless the point is measured.
    calibration::Estimate frequency{}, gamma{}, rho{}, phi{}, v_rms{}, v_D{}, D{}, efficiency{};
    calibration::Estimate tilt{};    // by gravity, rad
    double phi_systematic = NAN;     // standard error of phi by those of high_pass_hz and low_pass_hz, rad
    calibration::Estimate corner{};  // of the accelerometer, Hz: by the cameras and the settings
    double true_v_D = NAN;           // m/s, of a simulated bench
    double chi2 = NAN;               // of the passes, per degree of freedom
    double periods = 0;              // measured, all passes
    double travel_m = NAN;           // displacement of the walker, settling included
    int frames = 0, frames_lost = 0;
    int passes = 0, begun = 0;
    std::string recording{};  // of the first pass
    int measurement = 0;
    std::string time{};   // end of the last pass
    std::string doubt{};  // first note that questions a pass, see reduction::doubts_of(); empty: none
};

struct PointHarmonic {
    int point = 0;
    reduction::MeasuredHarmonic measured{};
    double asked = 0, asked_phase = 0;  // m/s^2, rad
};

struct PointPhase {
    int point = 0;
    double phase = 0, x_m = NAN, x_sd_m = NAN, v_mps = NAN, v_sd_mps = NAN, v_base_mps = NAN;
};

struct PointStick {
    int point = 0, pass = 0;
    reduction::StickInterval interval{};
};

struct PointPass {
    int point = 0, pass = 0;
    std::string recording{};
    int measurement = 0;
    double from_s = NAN, to_s = NAN, periods = 0, x_from_m = NAN, x_to_m = NAN;
    calibration::Estimate v_D{};
    double true_v_D = NAN;
    std::string how{}, reason{};
};

struct PointsTable {
    double gravity = paper_g;  // m/s^2, at the place of the bench
    std::vector<PointRow> points;
    std::vector<PointHarmonic> harmonics;  // max_harmonics rows for each point
    std::vector<PointPhase> cycle;         // cycle_phases rows for each point
    std::vector<PointStick> stick;
    std::vector<PointPass> passes;  // that count
    bool smoothed = false;          // of a file of version 1, whose v may be smoothed across kinks
    bool before_corners = false;    // of a file without the columns `corner`, whose doubts have other words
};

/// The groups with their columns, for POINTS.md.
std::vector<recorded::GroupLayout> point_places();

/// Writes campaign.nxs; a reader sees the file as it was before, or the complete new one. plan: its text.
/// DeviceError when the disk fails.
void write_points(const std::filesystem::path& file, const std::string& title, const std::string& plan,
                  const PointsTable& table);
/// True for a file that write_points() made; false for any other, also a recording.
bool has_points(const std::filesystem::path& file);
/// Reads such a file. InputError names the column in which it is damaged.
PointsTable read_points(const std::filesystem::path& file);

/// Bitwise differences, one sentence for each column, with the number of the point.
std::vector<std::string> differences(const PointsTable& stored, const PointsTable& now);

/// The tables, for "shakerd export".
std::vector<exporting::ExportTable> export_tables(const PointsTable& table);

}  // namespace shaker::campaign
