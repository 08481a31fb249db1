#pragma once
// shakerd recover: a recording whose writer ended without closing it.
#include <filesystem>

namespace shaker::commands {

struct RecoverOptions {
    std::filesystem::path file;  // or its .part
    bool json = false;
};
/// Finishes the recording that a crash interrupted: writes a new file under its name with all intact data. A
/// finished recording is only checked against its checksums; false when it was changed.
bool recover(const RecoverOptions& options);

}  // namespace shaker::commands
