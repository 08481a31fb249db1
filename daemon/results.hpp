#pragma once
// A reduction as people and programs read it.
#include <map>
#include <string>
#include <vector>

#include "daemon/reduction/reduction.hpp"
#include "daemon/trip_record.hpp"
#include "drivers/devices.hpp"

namespace shaker {

/// What a device had counted at the end of a run.
struct DeviceReport {
    std::string device;
    std::string what;  // is counted: "samples", "frames"
    DeviceCounts counts;
};

/// A table for a person: values with their standard errors, in the lab's units.
std::string results_text(const Reduction& reduction);

/// One JSON object, SI units in the key names: v_D_mps, v_D_se_mps, D_m, D_se_m, frequency_hz, gamma_mps2,
/// rho, phi_rad, efficiency, harmonics, accelerometer_late_s, accelerometer_ppm, frames, frames_lost, stick,
/// ... (README). What could not be determined is null. `more`: further numbers, by key; `devices`: what each
/// has counted; `trips`: why the run was stopped, when it was.
std::string results_json(const Reduction& reduction, const std::map<std::string, double>& more = {},
                         const std::vector<DeviceReport>& devices = {},
                         const std::vector<RecordedTrip>& trips = {});

/// The same of a stopped run without results: "trips", and "not_reduced" with the reason.
std::string trips_json(const std::vector<RecordedTrip>& trips, const std::string& why);

/// One sentence for each device that lost something.
std::vector<std::string> notes_on(const std::vector<DeviceReport>& devices);

/// "14.58 +- 0.03": as many digits as the error leaves meaning to.
std::string with_error(double value, double sigma);

}  // namespace shaker
