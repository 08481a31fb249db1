#pragma once
// Sessions of footage that shakerd did not record, for "shakerd reduce" and "shakerd track".
#include <filesystem>

#include "daemon/manual/command.hpp"
#include "daemon/sandbox/confined.hpp"

namespace shaker::sandbox {

/// Rights to read a session: its files are found in a child that can read nothing but session.toml.
struct SessionRights {
    int status = manual::exit_ok;  // of that child
    Confinement allowed{};
};
SessionRights rights_for_session(const std::filesystem::path& session);

}  // namespace shaker::sandbox
