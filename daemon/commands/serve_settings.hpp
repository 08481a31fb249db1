#pragma once
// The settings of the daemon: one TOML file with the tables [serve] and [run].
#include <filesystem>

#include "daemon/commands/serve_command.hpp"
#include "daemon/remote/server.hpp"
#include "daemon/run/run_settings.hpp"

namespace shaker::commands {

struct ServeSettings {
    run::RunOptions run;
    remote::ServerSettings server;
    std::filesystem::path recordings = ".";  // folder
    double longest_recording_s = 3600;       // all of one is in memory until it is finished
    calibration::Estimate mu{NAN, NAN};      // [serve] mu, mu_se: of walker and base
};

/// What is built in, changed by the file (none when empty), changed by the command line. [serve]: address,
/// http_port, scpi_port, hosts (names it answers to), token_file, page, recordings (folders). A relative path
/// is one beside the file. InputError with file, line, key, value and range; for an address that other
/// machines reach without a token; and for a token file that others may read.
ServeSettings serve_settings(const ServeOptions& options);

}  // namespace shaker::commands
