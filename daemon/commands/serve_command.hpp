#pragma once
// shakerd serve: a bench on call, with its remote control.
#include <filesystem>
#include <string>

namespace shaker::commands {

struct ServeOptions {
    std::filesystem::path settings;  // empty: the built-in settings
    std::string rig;                 // empty: the rig of the settings
    std::filesystem::path scene, page, recordings;
    int http_port = -1, scpi_port = -1;  // negative: the ports of the settings
};
/// Runs until SIGTERM or SIGINT, then stops the drive softly and finishes the recording.
void serve(const ServeOptions& options);

}  // namespace shaker::commands
