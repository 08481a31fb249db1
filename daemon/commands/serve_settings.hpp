#pragma once
// The settings of the daemon: one TOML file with the tables [serve] and [run].
#include <filesystem>
#include <string>

#include "daemon/remote/server.hpp"
#include "daemon/run/run_settings.hpp"

namespace shaker::commands {

struct ServeOptions {
    std::filesystem::path settings;  // empty: the built-in settings
    std::string rig;                 // empty: the rig of the settings
    std::filesystem::path scene, page, recordings;
    int http_port = -1, scpi_port = -1;  // negative: the ports of the settings
};

struct ServeSettings {
    run::RunOptions run;
    remote::ServerSettings server;
    std::filesystem::path recordings = ".";  // folder
    std::filesystem::path plans;             // folder of the plans that clients order by name
    double longest_recording_s = 3600;       // the streams of a recording stay in memory until it is finished
    calibration::Estimate mu{NAN, NAN};      // [serve] mu, mu_se: friction coefficient of walker and base
};

/// The built-in settings, changed by the file (if given), changed by the command line. [serve]: address,
/// http_port, scpi_port, scpi_socket (RUNTIME_DIRECTORY/scpi as a service, else none), host (its name in a
/// network), token_file, page, recordings, plans (folders; page: else the program's own; plans: else those
/// installed with the program).
/// Relative paths start at the folder of the file. InputError with file, line, key, value and range; also for
/// an address that other machines reach without a token, and for a token file that other users may read.
ServeSettings serve_settings(const ServeOptions& options);

}  // namespace shaker::commands
