#pragma once
// Leads an operator through the attitudes of an accelerometer.
#include <filesystem>
#include <functional>
#include <string>

#include "daemon/commands/calibrate/held_records.hpp"

namespace shaker::commands {

struct LeadOptions {
    std::string rig = "sim:";
    std::filesystem::path scene{};  // of the simulated rig; gives the attitudes of its sensor
    double gravity = 9.8;           // m/s^2
    double hold_s = 2;              // of rest in each attitude
};

/// Opens the rig and waits until the sensor was held in each of the standard attitudes; nothing is driven. An
/// attitude is accepted when the sensor was at rest for the hold time (HeldFinder); it gets the name that was
/// asked for. After each, `show` receives a line with its number, the condition number and what is missing,
/// and `keep` its samples as rows of a CSV file, after the header. InputError when no attitude was held for 5
/// min.
HeldRecords lead(const LeadOptions& options, const std::function<void(const std::string&)>& show,
                 const std::function<void(const std::string&)>& keep);

}  // namespace shaker::commands
