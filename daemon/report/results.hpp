#pragma once
// Results of a reduction as text and as JSON.
#include <map>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"
#include "daemon/recording/tables/trip_table.hpp"
#include "daemon/reduction/reduction.hpp"
#include "drivers/devices.hpp"

namespace shaker::report {

/// A table of values with standard errors, in units of the laboratory (mm, deg, %).
std::string results_text(const reduction::Reduction& reduction);

/// One JSON object, SI units in the key names: v_D_mps, v_D_se_mps, D_m, D_se_m, frequency_hz, gamma_mps2,
/// rho, phi_rad, efficiency, harmonics, accelerometer_late_s, accelerometer_ppm, frames, frames_lost,
/// frames_doubtful, stick,
/// ... A value that could not be determined is null. `more`: further numbers by key; `devices`: counts of
/// each device; `trips`: the causes if limits stopped the run.
std::string results_json(const reduction::Reduction& reduction,
                         const std::map<std::string, double>& more = {},
                         const std::vector<DeviceReport>& devices = {},
                         const std::vector<recording::RecordedTrip>& trips = {});

/// The same for a stopped run without results: "trips", and "not_reduced" with the reason.
std::string trips_json(const std::vector<recording::RecordedTrip>& trips, const std::string& why);

/// One sentence for each device that lost something.
std::vector<std::string> notes_on(const std::vector<DeviceReport>& devices);

/// Result of a cycle without a stick: "never for over 0.031 T", the shortest stick that would have been seen,
/// in units of the period (Reduction::shortest_visible_stick).
std::string no_stick_text(double shortest_visible);

/// "+3.012 um/s = +0.020 %": measured minus expected, both given in m/s. The share is left out where the
/// expected value is not larger than the measured one's error, 0 for example: it would say nothing.
std::string speed_difference(const calibration::Estimate& measured, double expected, int digits);

}  // namespace shaker::report
