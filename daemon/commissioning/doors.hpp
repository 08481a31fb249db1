#pragma once
// Aborts given at a daemon's doors, as clients give them.
#include <filesystem>

namespace shaker::commissioning {

/// Each function aborts over a new connection to this computer and returns when the daemon has acknowledged
/// that the output obeys. DeviceError when it does not.
void abort_by_scpi(int port);
void abort_by_socket(const std::filesystem::path& socket);
void abort_by_http(int port);

}  // namespace shaker::commissioning
